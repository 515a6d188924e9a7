"""The solver that draws from a continuous flow."""

from __future__ import annotations

from typing import ClassVar

from pipeline.learning.node_ik import METHOD
from pipeline.learning.solver import LatentSolver


class NodeIkSolver(LatentSolver):
    """The best of many draws of a continuous flow; `latent_scale` is that of its noise."""

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
