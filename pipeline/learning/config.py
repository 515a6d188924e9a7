"""Types of `conf/model` and `conf/train`: networks, losses, optimiser and schedule."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive, positive_all, within
from pipeline.learning.registry import kinds

SIZES = {"position": 3, "pose": 7}
KINDS_OF_GOALS = ({"joints", "posture"}, {"link", "position"}, {"link", "pose"}, {"clearance"})
FLOAT32, BFLOAT16 = "float32", "bfloat16"
PRECISIONS = (FLOAT32, "bfloat16_backward", BFLOAT16)


@dataclass
class ConstraintConfig:
    """A secondary goal of training: in joint space, for another link, or against self-collision.

    Either ``joints`` with ``posture``, or ``link`` with ``position`` or ``pose``, or ``clearance``.

    Attributes:
        weight: Weight of its penalty beside the losses of the pose.
        joints: Names of joints, or their numbers, counted from 0 at the base.
        posture: What they should be, rad or m: one value for all or one each.
        link: Name of a link of the robot.
        position: Where its frame should be, base frame, m.
        pose: The same with a rotation: x y z qw qx qy qz.
        clearance: Distance below which two links of the robot are pushed apart, m.
    """

    weight: float = MISSING
    joints: list[Any] | None = None
    posture: Any = None
    link: str | None = None
    position: list[float] | None = None
    pose: list[float] | None = None
    clearance: float | None = None

    def __post_init__(self) -> None:
        """Refuse goals of no kind, or of several."""
        positive("train.constraints: weight", self.weight)
        names = ("joints", "posture", *SIZES, "link", "clearance")
        given = {name for name in names if self._given(name)}
        if given not in KINDS_OF_GOALS:
            raise ValueError(
                "a constraint of train.constraints has joints and posture, or link and position, "
                f"or link and pose, or clearance, got {', '.join(sorted(given)) or 'none of them'}"
            )
        if self.clearance is not None:
            positive("train.constraints: clearance", self.clearance)
        for name, size in SIZES.items():
            if self._given(name) and len(getattr(self, name)) != size:
                raise ValueError(
                    f"train.constraints: {name} must be {size} numbers, got {getattr(self, name)}"
                )

    def _given(self, name: str) -> bool:
        return getattr(self, name) is not None


@dataclass
class ModelConfig:
    """Architecture of a network: the keys that all kinds have."""

    name: str = MISSING
    kind: str = MISSING
    hidden: list[int] = MISSING
    tanh_layers: int = MISSING
    width: int = MISSING
    heads: int = MISSING

    def __post_init__(self) -> None:
        """Refuse layers without neurons and a count of tanh layers beyond the network."""
        one_of("model.kind", self.kind, kinds())
        positive_all("model.hidden", self.hidden)
        positive("model.width", self.width)
        positive("model.heads", self.heads)
        within("model.tanh_layers", self.tanh_layers, 1, len(self.hidden) + 1)


@dataclass
class TrainConfig:
    """Losses, optimiser and schedule."""

    loss: str = MISSING
    position_beta: float = MISSING
    rotation_beta: float = MISSING
    position_weight: float = MISSING
    rotation_weight: float = MISSING
    batch_size: int = MISSING
    learning_rate: float = MISSING
    epochs: int = MISSING
    warm_up_steps: int = MISSING
    weight_decay: float = MISSING
    gradient_clip: float | None = MISSING
    mean_head_weight: float = MISSING
    mean_head_weight_until: float = MISSING
    kinematics: str = MISSING
    negate_input: bool = MISSING
    device: str = MISSING
    precision: str = MISSING
    float32_from: float = MISSING
    step: str = MISSING
    validations: int = MISSING
    checkpoint_s: float = MISSING
    poses: int = MISSING
    variance_of: str = MISSING
    variance_weight: float = MISSING
    variance_samples: int = MISSING
    constraints: list[ConstraintConfig] = MISSING
    constraint_scale: float = MISSING
    keep: str = MISSING
    replicate: int = MISSING
    source: str = (
        MISSING  # `train.from` in YAML and on the command line: `from` is a Python keyword
    )

    def __post_init__(self) -> None:
        """Refuse rates, sizes and names that cannot be."""
        one_of("train.loss", self.loss, ("smooth", "former", "matrix"))
        one_of(
            "train.kinematics",
            self.kinematics,
            ("auto", "compiled", "products", "pytorch_kinematics"),
        )
        one_of("train.step", self.step, ("auto", "eager", "captured"))
        one_of("train.device", self.device, ("auto", "cpu", "cuda"))
        one_of("train.precision", self.precision, PRECISIONS)
        within("train.float32_from", self.float32_from, 0, 1)
        one_of("train.keep", self.keep, ("last", "best"))
        at_least("train.poses", self.poses, 0)
        one_of("train.variance_of", self.variance_of, ("mean", "each"))
        at_least("train.variance_weight", self.variance_weight, 0)
        at_least("train.variance_samples", self.variance_samples, 2)
        at_least("train.constraint_scale", self.constraint_scale, 0)
        at_least("train.replicate", self.replicate, 0)
        one_of("train.from", self.source, ("default", "best", "shipped"))
        for name in ("position_beta", "rotation_beta", "batch_size", "learning_rate", "epochs"):
            positive(f"train.{name}", getattr(self, name))
        if self.gradient_clip is not None:
            positive("train.gradient_clip", self.gradient_clip)
        for name in ("validations", "checkpoint_s"):
            positive(f"train.{name}", getattr(self, name))
        for name in ("position_weight", "rotation_weight", "warm_up_steps", "weight_decay"):
            at_least(f"train.{name}", getattr(self, name), 0)
        for name in ("mean_head_weight", "mean_head_weight_until"):
            within(f"train.{name}", getattr(self, name), 0, 1)

    @property
    def max_gradient_norm(self) -> float:
        """Largest norm of the gradient; infinite where none is scaled down."""
        return math.inf if self.gradient_clip is None else self.gradient_clip
