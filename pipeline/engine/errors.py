"""Errors of engines."""

from pipeline.errors import PipelineError


class EngineError(PipelineError):
    """An engine that cannot start, or tasks whose workers died."""


class TaskFault(RuntimeError):  # noqa: N818 - a fault of the code, told with its own traceback
    """A task that raised what no user can mend, with the traceback of its worker."""
