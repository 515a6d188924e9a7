"""Errors of perception."""

from pipeline.errors import PipelineError


class PerceptionError(PipelineError):
    """A camera that cannot be, a detector that does not fit, or a picture of another kind."""
