"""Errors of the grasp experiment."""

from pipeline.errors import PipelineError


class GraspError(PipelineError):
    """A scene that cannot be built, or a robot that has none."""
