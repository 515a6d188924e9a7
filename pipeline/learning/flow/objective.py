"""What a flow is trained for: the likelihood of the joints that the poses were made from."""

from __future__ import annotations

import torch
from torch import Tensor

from pipeline.learning.config import TrainConfig
from pipeline.learning.flow.network import FlowNetwork, Latents, draw_latents
from pipeline.learning.kinematics import make_kinematics
from pipeline.learning.losses import tip_errors
from pipeline.learning.objective import ERRORS_BATCH
from pipeline.seeding import derive_seed
from robots import Robot


class FlowObjective:
    """Negative log-likelihood, with the noise of SoftFlow.

    The joints that reach a pose lie on a thin manifold, where a density has no bounds. Noise of a
    scale that is drawn anew for each row and given to the network gives it a thickness, which is
    switched off for draws (Kim et al., *SoftFlow*, NeurIPS 2020, as in IKFlow).

    Args:
        robot: Gives forward kinematics.
        network: The flow, on the device.
        train: Names the kinematics.
        device: Where batches lie.
        seed: Root of the noise: that of a step follows from it and the step.
    """

    def __init__(
        self,
        robot: Robot,
        network: FlowNetwork,
        train: TrainConfig,
        device: torch.device,
        seed: int,
    ) -> None:
        self.network, self.seed = network, seed
        self.kinematics = make_kinematics(robot, train.kinematics, device)

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`; in nats, of joints scaled to unit variance."""
        generator = torch.Generator().manual_seed(derive_seed(self.seed, "step", step))
        share = torch.rand(len(poses), 1, generator=generator).to(poses.device)
        noise = torch.randn(joints.shape, generator=generator).to(poses.device)
        thick = self.network.unit(joints) + self.network.noise * share * noise
        likelihood: Tensor = self.network.density(poses, share).log_prob(thick)
        return -likelihood.mean()

    @torch.no_grad()
    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return errors (N,) in mm and deg of one draw for each of poses (N, 7).

        Their mean is what IKFlow reports: that over draws, not of the best one.
        """
        latents = draw_latents(len(poses), 1, self.network.dof, derive_seed(self.seed, "errors"))
        answers = [
            self.network.draws(poses[rows], Latents(*(values[rows] for values in latents)))
            for rows in torch.arange(len(poses)).split(ERRORS_BATCH)
        ]
        return tip_errors(self.kinematics(torch.cat(answers).flatten(0, 1)), poses)
