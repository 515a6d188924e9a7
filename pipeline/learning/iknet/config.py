"""Keys of conf/model for IKNet."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, positive
from pipeline.learning.config import ModelConfig


@dataclass
class IkNetModel(ModelConfig):
    """Architecture of IKNet and the share of forward kinematics in its loss.

    Attributes:
        embedding: Values that describe a pose, of which the weights of primary networks are made.
        components: Gaussians of the angle of each joint.
        forward_weight: Weight of the pose loss of one draw beside the likelihood.
    """

    embedding: int = MISSING
    components: int = MISSING
    forward_weight: float = MISSING

    def __post_init__(self) -> None:
        """Refuse networks without an embedding or components."""
        super().__post_init__()
        positive("model.embedding", self.embedding)
        positive("model.components", self.components)
        at_least("model.forward_weight", self.forward_weight, 0)
