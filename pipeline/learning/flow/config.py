"""Keys of conf/model for the normalizing flow."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, positive, positive_all
from pipeline.learning.config import ModelConfig


@dataclass
class FlowModel(ModelConfig):
    """Architecture of a flow.

    Attributes:
        encoder: Neurons of the hidden layer of each residual block of the encoder.
        couplings: Blocks of two couplings each.
        components: Gaussians of the base.
        noise: Largest standard deviation of the training noise on joints of unit variance.
    """

    encoder: list[int] = MISSING
    couplings: int = MISSING
    components: int = MISSING
    noise: float = MISSING

    def __post_init__(self) -> None:
        """Refuse flows without couplings or components."""
        super().__post_init__()
        positive_all("model.encoder", self.encoder)
        positive("model.couplings", self.couplings)
        positive("model.components", self.components)
        at_least("model.noise", self.noise, 0)
