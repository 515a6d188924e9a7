"""What NODE IK is trained for: the likelihood of the joints that the poses were made from."""

from __future__ import annotations

import torch
from torch import Tensor

from pipeline.learning.networks import HALF_WIDTH
from pipeline.learning.node_ik.network import NodeIk
from pipeline.learning.objective import SamplingObjective


class NodeIkObjective(SamplingObjective):
    """Negative log-likelihood, with the noise of SoftFlow and Hutchinson's estimate of the trace.

    Noise of a scale that is drawn anew for each row and given to the network makes the thin
    manifold of solutions thick (Kim et al., *SoftFlow*, NeurIPS 2020).
    """

    network: NodeIk

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`; in nats, of joints scaled to unit variance."""
        network, generator = self.network, self.generator(step)
        share = torch.rand(len(poses), 1, generator=generator).to(poses.device)
        noise = torch.randn(joints.shape, generator=generator).to(poses.device)
        directions = (len(poses), network.probes, network.dof)
        probes = torch.randn(directions, generator=generator).to(poses.device)
        thick = HALF_WIDTH * network.unit(joints) + network.noise * share * noise
        return -network.log_density(poses, thick, share, probes)[0].mean()
