"""Types of the primitives beside grasping; conf/grasp/scene owns the values."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, positive, positive_all


@dataclass
class PushConfig:
    """How the closed hand pushes a thing over the table."""

    stand_off: float = MISSING  # m
    distance: float = MISSING  # m
    height: float = MISSING  # m
    directions: list[float] = MISSING  # deg
    yaws: list[float] = MISSING  # deg
    tilts: list[float] = MISSING  # deg
    min_displacement: float = MISSING  # m

    def __post_init__(self) -> None:
        """Refuse pushes that go nowhere."""
        for name in ("stand_off", "distance", "min_displacement"):
            positive(f"grasp.scenes: push.{name}", getattr(self, name))
        at_least("grasp.scenes: push.height", self.height, 0)
        if not (self.directions and self.yaws and self.tilts):
            raise ValueError(
                "grasp.scenes: push needs a direction, a yaw and a tilt [deg] at least"
            )


@dataclass
class PointConfig:
    """How the hand points at a thing."""

    distances: list[float] = MISSING  # m
    yaws: list[float] = MISSING  # deg
    tilts: list[float] = MISSING  # deg
    stretched: list[str] = MISSING
    hold_s: float = MISSING  # s
    beside: float = MISSING  # m

    def __post_init__(self) -> None:
        """Refuse gestures without a direction to point in."""
        positive_all("grasp.scenes: point.distances", self.distances)
        if not self.yaws or not self.tilts:
            raise ValueError("grasp.scenes: point needs at least one yaw and one tilt [deg]")
        at_least("grasp.scenes: point.hold_s", self.hold_s, 0)
        positive("grasp.scenes: point.beside", self.beside)
