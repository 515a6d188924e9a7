"""Keys of conf/model for NODE IK."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, positive
from pipeline.learning.config import ModelConfig


@dataclass
class NodeIkModel(ModelConfig):
    """Architecture of the velocity and how it is integrated.

    Attributes:
        steps: Steps of the fourth-order Runge-Kutta method from noise to joints.
        probes: Directions of each row of which the trace is estimated.
        noise: Largest standard deviation of the training noise on joints of unit variance.
    """

    steps: int = MISSING
    probes: int = MISSING
    noise: float = MISSING

    def __post_init__(self) -> None:
        """Refuse an integration without steps and a trace without directions."""
        super().__post_init__()
        positive("model.steps", self.steps)
        positive("model.probes", self.probes)
        at_least("model.noise", self.noise, 0)
