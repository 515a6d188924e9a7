"""Keys of conf/model for the generative adversarial network."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, positive, positive_all
from pipeline.learning.config import ModelConfig


@dataclass
class GanModel(ModelConfig):
    """Architecture of generators and discriminator, and weights of the generators' losses.

    Attributes:
        generators: Generators of the ensemble.
        noise: Normal numbers that a generator takes.
        discriminator: Neurons of each hidden layer of the discriminator.
        adversarial_weight: Weight of what the discriminator says, beside the pose loss.
        limit_weight: Weight of the squared distance beyond the joint limits.
    """

    generators: int = MISSING
    noise: int = MISSING
    discriminator: list[int] = MISSING
    adversarial_weight: float = MISSING
    limit_weight: float = MISSING

    def __post_init__(self) -> None:
        """Refuse an ensemble of none, generators without noise and negative weights."""
        super().__post_init__()
        positive("model.generators", self.generators)
        positive("model.noise", self.noise)
        positive_all("model.discriminator", self.discriminator)
        at_least("model.adversarial_weight", self.adversarial_weight, 0)
        at_least("model.limit_weight", self.limit_weight, 0)
