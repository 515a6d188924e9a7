"""The solver that samples from a normalizing flow."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import ClassVar

from torch import Tensor

from pipeline.learning.flow import METHOD
from pipeline.learning.flow.network import FlowNetwork, draw_latents
from pipeline.learning.solver import LatentSolver


class FlowIk(LatentSolver):
    """The best of many draws; `latent_scale` is that of each component of the base."""

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
    requires: ClassVar[tuple[str, ...]] = ("torch", "zuko")
    network: FlowNetwork

    def _sampler(self, count: int, seed: int) -> Callable[[Tensor], Tensor]:
        latents = draw_latents(1, count, self.robot.dof, seed)
        latents = latents._replace(normal=latents.normal * self.latent_scale)
        return partial(self.network.draws, latents=latents)
