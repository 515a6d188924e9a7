"""The solver that draws from the generators of an adversarial network."""

from __future__ import annotations

from typing import ClassVar

from pipeline.learning.gan import METHOD
from pipeline.learning.solver import LatentSolver


class GanIk(LatentSolver):
    """The best of many draws of an ensemble; `latent_scale` is that of the noise."""

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
