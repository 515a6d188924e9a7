"""Keys of conf/model for the networks of CycleIK."""

from __future__ import annotations

from dataclasses import dataclass

from pipeline.checks import positive
from pipeline.learning.config import ModelConfig


@dataclass
class CycleIkModel(ModelConfig):
    """Architecture of kind mlp or experts.

    Attributes:
        experts: Of kind experts, the regions of pose space; an mlp is one network for all poses.
    """

    experts: int = 1

    def __post_init__(self) -> None:
        """Refuse networks without experts, and an mlp with several heads."""
        super().__post_init__()
        positive("model.experts", self.experts)
        if self.kind == "mlp" and self.heads != 1:
            raise ValueError(f"model.heads must be 1 for model.kind=mlp, got {self.heads}")
