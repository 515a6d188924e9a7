"""The solver that samples from a normalizing flow."""

from __future__ import annotations

from typing import ClassVar

from pipeline.learning.flow import METHOD
from pipeline.learning.solver import LatentSolver


class FlowIk(LatentSolver):
    """The best of many draws; `latent_scale` is that of each component of the base."""

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
    requires: ClassVar[tuple[str, ...]] = ("torch", "zuko")
