"""What CycleIK is trained for: that the joints of a pose lead back to the pose."""

from __future__ import annotations

import torch
from torch import Tensor

from pipeline.learning.config import TrainConfig
from pipeline.learning.constraints import make_penalty
from pipeline.learning.kinematics import make_kinematics
from pipeline.learning.losses import PoseLoss, tip_errors, winner_takes_most
from pipeline.learning.networks import IkNetwork
from pipeline.learning.objective import ERRORS_BATCH
from robots import Robot


class CycleObjective:
    """The cycle pose -> joints -> pose, for networks with one or several hypotheses.

    Args:
        robot: Gives forward kinematics.
        network: Poses (N, 7) to hypotheses (N, K, dof).
        train: Losses, share of the heads, negation of the input.
        device: Where batches lie.
        seed: Unused: this objective draws nothing.
    """

    def __init__(
        self,
        robot: Robot,
        network: IkNetwork,
        train: TrainConfig,
        device: torch.device,
        seed: int = 0,
    ) -> None:
        self.network = network
        self.train = train
        self.kinematics = make_kinematics(robot, train.kinematics, device)
        self.pose_loss = PoseLoss(train)
        self.penalty = make_penalty(robot, train, device)

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`; the best hypothesis of a pose counts most."""
        return self.loss_of(self.network_input(poses, step), poses, self._mean_head_weight(done))

    def network_input(self, poses: Tensor, step: int) -> Tensor:
        """Return what the network sees of poses (N, 7): with ``negate_input`` -q on odd steps."""
        if self.train.negate_input and step % 2:
            return torch.cat((poses[:, :3], -poses[:, 3:]), dim=1)
        return poses

    def loss_of(
        self, network_input: Tensor, poses: Tensor, mean_head_weight: float = 0.0
    ) -> Tensor:
        """Return the scalar loss of a batch, a function of tensors alone where there is one head.

        Args:
            network_input: (N, 7) what the network sees.
            poses: (N, 7) what it is to reach.
            mean_head_weight: Weight of the mean of all hypotheses.
        """
        answers = self.network(network_input).flatten(0, 1)
        losses = self.pose_loss(*self.kinematics(answers), self._for_heads(poses))
        if self.penalty is not None:
            losses = losses + self.penalty(answers)
        return winner_takes_most(losses.unflatten(0, (len(poses), -1)), mean_head_weight)

    @torch.no_grad()
    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return errors (N,) in mm and deg of the best hypothesis for each of poses (N, 7)."""
        parts = [self._best_errors(part) for part in poses.split(ERRORS_BATCH)]
        positions, rotations = zip(*parts, strict=True)
        return torch.cat(positions), torch.cat(rotations)

    @torch.no_grad()
    def validation_losses(self, poses: Tensor) -> tuple[float, float]:
        """Return position and rotation loss, unweighted, of the best hypotheses on poses (N, 7)."""
        position, rotation = self.pose_loss.parts(*self._reached(poses), self._for_heads(poses))
        both = self.train.position_weight * position + self.train.rotation_weight * rotation
        best = both.unflatten(0, (len(poses), -1)).argmin(dim=1, keepdim=True)
        means = [
            part.unflatten(0, (len(poses), -1)).gather(1, best) for part in (position, rotation)
        ]
        return float(means[0].mean()), float(means[1].mean())

    def _reached(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Tip frames of all hypotheses: positions (N K, 3) and rotations (N K, 3, 3)."""
        return self.kinematics(self.network(poses).flatten(0, 1))

    def _for_heads(self, poses: Tensor) -> Tensor:
        """Repeat poses (N, 7) for each hypothesis, (N K, 7)."""
        heads = self.network.heads
        return poses if heads == 1 else poses.repeat_interleave(heads, dim=0)

    def _mean_head_weight(self, done: float) -> float:
        """Weight of the mean of all heads: 1 at the start, `mean_head_weight` after a stretch."""
        until = self.train.mean_head_weight_until
        rest = max(0.0, 1 - done / until) if until > 0 else 0.0
        return self.train.mean_head_weight + (1 - self.train.mean_head_weight) * rest

    def _best_errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        position, rotation = self._reached(poses)
        targets = self._for_heads(poses)
        best = self.pose_loss(position, rotation, targets).unflatten(0, (len(poses), -1)).argmin(1)
        rows = torch.arange(len(poses), device=poses.device) * self.network.heads + best
        return tip_errors((position[rows], rotation[rows]), poses)
