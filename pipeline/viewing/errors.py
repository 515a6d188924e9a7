"""What cannot be shown."""

from __future__ import annotations

from pipeline.errors import PipelineError


class ViewError(PipelineError):
    """Something that cannot be shown, and why."""
