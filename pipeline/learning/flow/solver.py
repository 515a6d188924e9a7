"""The solver that samples from a normalizing flow."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, ClassVar

from torch import Tensor

from baselines import SettingError
from pipeline.learning.flow import METHOD
from pipeline.learning.flow.network import FlowNetwork, draw_latents
from pipeline.learning.solver import SamplingSolver
from robots import Robot


class FlowIk(SamplingSolver):
    """The best of many draws of each pose.

    Args:
        robot: The robot it solves for.
        weights: Folder of weights.safetensors and card.json.
        samples: Draws of each pose.
        latent_scale: Scale of the normal numbers that draws start from. Below 1 the draws keep
            closer to the likeliest solutions of each component.
        **settings: Seed, tolerances and threads, see `SamplingSolver`.
    """

    kinds: ClassVar[tuple[str, ...]] = METHOD.kinds
    default_model: ClassVar[str] = METHOD.model
    requires: ClassVar[tuple[str, ...]] = ("torch", "zuko")
    network: FlowNetwork

    def __init__(
        self, robot: Robot, weights: str, samples: int, latent_scale: float, **settings: Any
    ) -> None:
        super().__init__(robot, weights, samples=samples, **settings)
        if samples < 1:
            raise SettingError(f"flow: expected samples >= 1, got {samples}")
        if not latent_scale >= 0:
            raise SettingError(f"flow: expected latent_scale >= 0, got {latent_scale}")
        self.latent_scale = latent_scale

    def _sampler(self, count: int, seed: int) -> Callable[[Tensor], Tensor]:
        latents = draw_latents(1, count, self.robot.dof, seed)
        latents = latents._replace(normal=latents.normal * self.latent_scale)
        return partial(self.network.draws, latents=latents)
