"""Types of the cameras and of the films; conf/grasp owns the values."""

from __future__ import annotations

from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.checks import at_least, positive


@dataclass
class CloseupConfig:
    """The second camera, which follows the hand; its picture lies beside that of the first."""

    distance: float = MISSING  # m
    yaw: float = MISSING  # deg


@dataclass
class CameraConfig:
    """The camera of the videos."""

    target: list[float] = MISSING  # m, base frame
    distance: float = MISSING  # m
    yaw: float = MISSING  # deg
    pitch: float = MISSING  # deg
    closeup: CloseupConfig = field(default_factory=CloseupConfig)


@dataclass
class VideoConfig:
    """Size and speed of the videos."""

    width: int = MISSING  # pixels
    height: int = MISSING  # pixels
    rate: float = MISSING  # Hz, of the simulated time
    closeup: int = MISSING  # pixels
    gif_width: int = MISSING  # pixels
    gif_rate: float = MISSING  # Hz, of the simulated time

    def __post_init__(self) -> None:
        """Refuse pictures without pixels and films without pictures."""
        for name in ("width", "height", "rate", "gif_rate"):
            positive(f"grasp.recording.{name}", getattr(self, name))
        for name in ("closeup", "gif_width"):
            at_least(f"grasp.recording.{name}", getattr(self, name), 0)
