"""A conditional normalizing flow over the joints that reach a pose, in the manner of IKFlow.

Ames, Morgan and Konidaris, *IKFlow: Generating diverse inverse kinematics solutions*, IEEE RA-L
7(3), 2022. The couplings are those of the library zuko. Two parts differ, both to train in minutes
rather than days: one encoder of the pose serves all couplings, and the base is a mixture whose
components can take a branch of solutions each, where IKFlow bends one Gaussian, padded with further
dimensions, into all of them.
"""

from __future__ import annotations

from functools import partial

import torch
from torch import Tensor, nn
from zuko.distributions import NormalizingFlow
from zuko.flows.coupling import GeneralCouplingTransform
from zuko.lazy import Flow
from zuko.mixtures import GMM
from zuko.transforms import MonotonicAffineTransform

from pipeline.learning.flow.config import FlowModel
from pipeline.learning.networks import (
    HALF_WIDTH,
    MATRIX_POSE_SIZE,
    ResidualBlocks,
    SamplingNetwork,
)
from robots import Robot

LEAST_SCALE = 1e-2  # a coupling scales by a factor between this and its inverse


class Coupling(GeneralCouplingTransform):
    """An affine coupling: one part of the joints shifts and scales the other. Starts as identity.

    Args:
        dof: Joints.
        context: Values that describe the pose.
        mask: (dof,) true for the joints that stay as they are.
        hidden: Neurons of each hidden layer of the network that finds shift and scale.
    """

    def __init__(self, dof: int, context: int, mask: Tensor, hidden: list[int]) -> None:
        super().__init__(
            dof,
            context,
            mask,
            univariate=partial(MonotonicAffineTransform, slope=LEAST_SCALE),
            hidden_features=hidden,
            activation=nn.LeakyReLU,
        )
        nn.init.zeros_(self.hyper[-1].weight)
        nn.init.zeros_(self.hyper[-1].bias)


class FlowNetwork(SamplingNetwork):
    """The density of joints given a pose, and draws from it.

    Args:
        robot: The robot.
        model: Width of the encoder and neurons of its residual blocks, blocks of two couplings,
            neurons of the couplings, components of the base, largest training noise.
    """

    def __init__(self, robot: Robot, model: FlowModel) -> None:
        super().__init__(robot, normals=robot.dof, choices=1)
        self.noise = model.noise
        self.entry = nn.Linear(MATRIX_POSE_SIZE + 1, model.width)
        self.blocks = ResidualBlocks(model.width, model.encoder)
        self.norm = nn.LayerNorm(model.width)
        couplings = []
        for _ in range(model.couplings):
            mask = torch.zeros(robot.dof, dtype=torch.bool)
            mask[torch.randperm(robot.dof)[: robot.dof // 2]] = True
            for kept in (mask, ~mask):
                couplings.append(Coupling(robot.dof, model.width, kept, list(model.hidden)))
        self.flow = Flow(couplings, _mixture(robot.dof, model))

    def density(self, poses: Tensor, noise: Tensor) -> NormalizingFlow:
        """Return the distribution of joints that are scaled to unit variance.

        Args:
            poses: (N, 7) metres and unit quaternions, scalar first.
            noise: (N, 1) in [0, 1], the share of the training noise that the joints carry.
        """
        return self.flow(self.context(poses, noise))

    def draws(self, poses: Tensor, latents: Tensor) -> Tensor:
        """See `SamplingNetwork.draws`; the noise of the training is switched off."""
        context = self.context(poses, poses.new_zeros(len(poses), 1)).unsqueeze(1)
        base = self.flow.base(context)
        shares = base.logits.softmax(dim=-1).cumsum(dim=-1)  # (N, 1, M)
        normal, component = latents.to(poses.device).split((self.dof, 1), dim=2)
        picked = (shares[..., :-1] < component).sum(dim=-1, keepdim=True)  # (N, K, 1)
        index = picked.expand(-1, -1, self.dof)
        centre, scale = (
            values.squeeze(1).gather(1, index) for values in (base.base.mean, base.base.stddev)
        )
        scaled = self.flow.transform(context).inv(centre + scale * normal)
        return self.inside(scaled / HALF_WIDTH)

    def context(self, poses: Tensor, noise: Tensor) -> Tensor:
        """Return what the couplings know (N, width) of poses (N, 7) and noise (N, 1)."""
        described = torch.cat((self.described(poses), 2 * noise - 1), dim=1)
        values = self.blocks(self.entry(described))
        context: Tensor = self.norm(values)
        return context


def _mixture(dof: int, model: FlowModel) -> GMM:
    """Gaussians whose weights, means and scales follow from the pose, scattered at the start."""
    count = model.components
    base = GMM(dof, model.width, components=count, covariance_type="diagonal", hidden_features=[])
    last = base.hyper[-1]
    with torch.no_grad():
        last.weight.mul_(0.1)
        last.bias.zero_()
        last.bias[count : count + count * dof].normal_(std=0.8)
        last.bias[count + count * dof :].fill_(-0.7)  # logarithm of the scale: half of a joint's
    return base
