"""Types of the `view` group; conf/view owns the values and comments every key with its unit."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, positive, within

LAST_PORT = 65535


@dataclass
class ViewConfig:
    """What is shown, and where the page is served."""

    solver: str = MISSING
    solvers: list[str] = MISSING
    host: str = MISSING
    port: int = MISSING
    open: bool = MISSING
    rate: float = MISSING  # Hz
    opacity: float = MISSING
    timed_calls: int = MISSING
    self_motion: float = MISSING  # rad or m
    trial: int = MISSING
    rows: str | None = None
    film: str | None = None

    def __post_init__(self) -> None:
        """Refuse ports that do not exist and pictures that do not come."""
        within("view.port", self.port, 0, LAST_PORT)
        within("view.opacity", self.opacity, 0.0, 1.0)
        positive("view.rate", self.rate)
        positive("view.timed_calls", self.timed_calls)
        positive("view.self_motion", self.self_motion)
        at_least("view.trial", self.trial, 0)
        if self.film is not None and not self.film.endswith(".mp4"):
            raise ValueError(f"view.film must be a file that ends in .mp4, got '{self.film}'")
