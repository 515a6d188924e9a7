"""What the equivariant model is trained for: a bound of the evidence of the robot's points."""

from __future__ import annotations

import torch
from torch import Tensor

from pipeline.learning.eem.network import Eem, divergence
from pipeline.learning.objective import SamplingObjective


class EemObjective(SamplingObjective):
    """Squared distances of decoded points, and the divergence of the posterior from the prior."""

    network: Eem

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`; points are in units of the reach."""
        network = self.network
        with torch.no_grad():
            points, given = network.graph.points(joints), network.graph.given(poses)
        posterior, prior = network.posteriors(points), network.priors(given)
        normal = torch.randn(posterior.mean.shape, generator=self.generator(step))
        latents = posterior.mean + posterior.log_scale.exp() * normal.to(poses.device)
        missed = (network.decoded(given, latents) - points).square().sum(dim=(1, 2))
        bound = network.reconstruction_weight * missed + divergence(posterior, prior)
        return bound.mean()
