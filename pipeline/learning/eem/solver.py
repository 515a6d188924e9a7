"""The solver that draws from the equivariant model."""

from __future__ import annotations

from typing import ClassVar

from pipeline.learning.eem import METHOD
from pipeline.learning.solver import LatentSolver


class EemIk(LatentSolver):
    """The best of many draws of points; `latent_scale` is that of the prior's deviation."""

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
