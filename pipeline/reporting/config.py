"""Types of `conf/report`: what success means, how sure numbers are, how figures look."""

from __future__ import annotations

from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive, positive_all, within
from pipeline.evaluation.config import NOT_FOUND_POLICIES, Tolerance


@dataclass
class SuccessConfig:
    """What counts as reached, each on its own family of errors."""

    strict: Tolerance = field(default_factory=Tolerance)
    loose: Tolerance = field(default_factory=Tolerance)
    paper: Tolerance = field(default_factory=Tolerance)


def tolerance_title(tolerance: Tolerance) -> str:
    """Return how a tolerance is written, such as ``1 mm / 1 deg``."""
    return f"{tolerance.position_mm:g} mm / {tolerance.rotation_deg:g} deg"


@dataclass
class LeaderboardConfig:
    """What a line of the leaderboard says of times."""

    shift_us: float = MISSING
    within_us: list[float] = MISSING

    def __post_init__(self) -> None:
        """Refuse a shift that is none, and limits that do not rise."""
        positive("report.leaderboard.shift_us", self.shift_us)
        positive_all("report.leaderboard.within_us", self.within_us)
        if not isinstance(self.within_us, str) and sorted(set(self.within_us)) != self.within_us:
            raise ValueError(f"report.leaderboard.within_us must rise, got {self.within_us}")


@dataclass
class ReportConfig:
    """Tables, figures and report.html."""

    title: str = MISSING
    not_found: str = MISSING
    success: SuccessConfig = field(default_factory=SuccessConfig)
    confidence: float = MISSING
    resamples: int = MISSING
    seed: int = MISSING
    dpi: int = MISSING
    embed_mb: float = MISSING
    leaderboard: LeaderboardConfig = field(default_factory=LeaderboardConfig)

    def __post_init__(self) -> None:
        """Refuse policies, confidences and counts that cannot be."""
        one_of("report.not_found", self.not_found, NOT_FOUND_POLICIES)
        within("report.confidence", self.confidence, 0.5, 0.9999)
        positive("report.resamples", self.resamples)
        at_least("report.seed", self.seed, 0)
        positive("report.dpi", self.dpi)
        at_least("report.embed_mb", self.embed_mb, 0)
