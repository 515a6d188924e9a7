"""The error of this package."""

from __future__ import annotations

from pipeline.errors import PipelineError


class LeaderboardError(PipelineError):
    """A file that was sent, or a committed one, that is not what the leaderboard takes."""
