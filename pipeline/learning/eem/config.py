"""Keys of conf/model for the equivariant model."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import positive
from pipeline.learning.config import ModelConfig


@dataclass
class EemModel(ModelConfig):
    """Architecture of encoder, prior and decoder, and the weight of what is reconstructed.

    Attributes:
        layers: Equivariant layers of each of the three.
        latent: Latent values of each point.
        reconstruction_weight: Weight of the squared distances of points, in units of the reach,
            beside the divergence of the posterior from the prior.
    """

    layers: int = MISSING
    latent: int = MISSING
    reconstruction_weight: float = MISSING

    def __post_init__(self) -> None:
        """Refuse networks without layers or latents."""
        super().__post_init__()
        positive("model.layers", self.layers)
        positive("model.latent", self.latent)
        positive("model.reconstruction_weight", self.reconstruction_weight)
