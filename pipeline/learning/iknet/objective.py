"""What IKNet is trained for: the likelihood of the joints that the poses were made from."""

from __future__ import annotations

from torch import Tensor

from pipeline.learning.iknet.network import IkNet
from pipeline.learning.objective import SamplingObjective


class IkNetObjective(SamplingObjective):
    """Negative log-likelihood, mean over the joints, and the pose that one draw reaches."""

    network: IkNet

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`; in nats of joints scaled to [-1, 1]."""
        loss = -self.network.log_likelihood(poses, joints).mean()
        if self.network.forward_weight:
            drawn = self.network.draws(poses, self.latents(poses, 1, step)).flatten(0, 1)
            reached = self.pose_loss(*self.kinematics(drawn), poses).mean()
            loss = loss + self.network.forward_weight * reached
        return loss
