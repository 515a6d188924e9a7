"""What a flow is trained for: the likelihood of the joints that the poses were made from."""

from __future__ import annotations

import torch
from torch import Tensor

from pipeline.learning.flow.network import FlowNetwork
from pipeline.learning.networks import HALF_WIDTH
from pipeline.learning.objective import SamplingObjective


class FlowObjective(SamplingObjective):
    """Negative log-likelihood, with the noise of SoftFlow.

    The joints that reach a pose lie on a thin manifold, where a density has no bounds. Noise of a
    scale that is drawn anew for each row and given to the network gives it a thickness, which is
    switched off for draws (Kim et al., *SoftFlow*, NeurIPS 2020, as in IKFlow). `errors` are those
    that IKFlow reports.
    """

    network: FlowNetwork

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`; in nats, of joints scaled to unit variance."""
        network, generator = self.network, self.generator(step)
        share = torch.rand(len(poses), 1, generator=generator).to(poses.device)
        noise = torch.randn(joints.shape, generator=generator).to(poses.device)
        thick = HALF_WIDTH * network.unit(joints) + network.noise * share * noise
        likelihood: Tensor = network.density(poses, share).log_prob(thick)
        return -likelihood.mean()
