"""The solver that draws from IKNet."""

from __future__ import annotations

from typing import ClassVar

from pipeline.learning.iknet import METHOD
from pipeline.learning.solver import LatentSolver


class IkNetIk(LatentSolver):
    """The best of many draws, joint after joint; `latent_scale` is that of each Gaussian."""

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
