"""Types of the configuration of training that need no torch."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from omegaconf import MISSING

from pipeline.checks import positive

SIZES = {"position": 3, "pose": 7}


@dataclass
class ConstraintConfig:
    """A secondary goal of training, in joint space or for another link of the robot.

    Either ``joints`` with ``posture``, or ``link`` with ``position`` or ``pose``.

    Attributes:
        weight: Weight of its penalty beside the losses of the pose.
        joints: Names of joints, or their numbers, counted from 0 at the base.
        posture: What they should be, rad or m: one value for all or one each.
        link: Name of a link of the robot.
        position: Where its frame should be, base frame, m.
        pose: The same with a rotation: x y z qw qx qy qz.
    """

    weight: float = MISSING
    joints: list[Any] | None = None
    posture: Any = None
    link: str | None = None
    position: list[float] | None = None
    pose: list[float] | None = None

    def __post_init__(self) -> None:
        """Refuse goals that are neither of a posture nor of a link, or of both."""
        positive("train.constraints: weight", self.weight)
        given = {name for name in ("joints", "posture", *SIZES, "link") if self._given(name)}
        if given not in ({"joints", "posture"}, {"link", "position"}, {"link", "pose"}):
            raise ValueError(
                "a constraint of train.constraints has joints and posture, or link and position, "
                f"or link and pose, got {', '.join(sorted(given)) or 'none of them'}"
            )
        for name, size in SIZES.items():
            if self._given(name) and len(getattr(self, name)) != size:
                raise ValueError(
                    f"train.constraints: {name} must be {size} numbers, got {getattr(self, name)}"
                )

    def _given(self, name: str) -> bool:
        return getattr(self, name) is not None
