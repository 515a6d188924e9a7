"""A conditional normalizing flow over the joints that reach a pose, in the manner of IKFlow.

Ames, Morgan and Konidaris, *IKFlow: Generating diverse inverse kinematics solutions*, IEEE RA-L
7(3), 2022. The couplings are those of the library zuko. Two parts differ, both to train in minutes
rather than days: one encoder of the pose serves all couplings, and the base is a mixture whose
components can take a branch of solutions each, where IKFlow bends one Gaussian, padded with further
dimensions, into all of them.
"""

from __future__ import annotations

from functools import partial
from math import sqrt
from typing import NamedTuple

import torch
from torch import Tensor, nn
from zuko.distributions import NormalizingFlow
from zuko.flows.coupling import GeneralCouplingTransform
from zuko.lazy import Flow
from zuko.mixtures import GMM
from zuko.transforms import MonotonicAffineTransform

from pipeline.learning.flow.config import FlowModel
from pipeline.learning.networks import (
    MATRIX_POSE_SIZE,
    IkNetwork,
    ResidualBlocks,
    matrix_pose,
)
from robots import Robot

# Uniform joints, scaled from their limits to this, have the variance of the normal numbers that
# the flow starts from.
HALF_WIDTH = sqrt(3)
LEAST_SCALE = 1e-2  # a coupling scales by a factor between this and its inverse


class Latents(NamedTuple):
    """What K draws of N poses, or the same K of all poses, start from.

    Attributes:
        component: (N or 1, K) uniform in [0, 1), picks a component of the mixture.
        normal: (N or 1, K, dof) standard normal.
    """

    component: Tensor
    normal: Tensor


def draw_latents(poses: int, count: int, dof: int, seed: int) -> Latents:
    """Return the latents of ``count`` draws of each of ``poses`` poses: a function of the seed."""
    generator = torch.Generator().manual_seed(seed)
    component = torch.rand(poses, count, generator=generator)
    return Latents(component, torch.randn(poses, count, dof, generator=generator))


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


class FlowNetwork(IkNetwork):
    """The density of joints given a pose, and draws from it.

    Args:
        robot: The robot.
        model: Width of the encoder and neurons of its residual blocks, blocks of two couplings,
            neurons of the couplings, components of the base, largest training noise.
    """

    def __init__(self, robot: Robot, model: FlowModel) -> None:
        super().__init__(robot, heads=1)
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

    def forward(self, poses: Tensor) -> Tensor:
        """Return joints (N, 1, dof) in rad or m: one draw of each of poses (N, 7), always it."""
        return self.draws(poses, draw_latents(1, 1, self.dof, seed=0))

    def unit(self, joints: Tensor) -> Tensor:
        """Return joints (N, dof), in rad or m, as the flow takes them."""
        return (joints - self.joint_centre) / self.joint_scale * HALF_WIDTH

    def density(self, poses: Tensor, noise: Tensor) -> NormalizingFlow:
        """Return the distribution of unit joints.

        Args:
            poses: (N, 7) metres and unit quaternions, scalar first.
            noise: (N, 1) in [0, 1], the share of the training noise that the joints carry.
        """
        return self.flow(self.context(poses, noise))

    def draws(self, poses: Tensor, latents: Latents) -> Tensor:
        """Return joints (N, K, dof) in rad or m, inside the limits, that should reach poses (N, 7).

        The noise that the flow was trained with is switched off (its share is 0).
        """
        context = self.context(poses, poses.new_zeros(len(poses), 1)).unsqueeze(1)
        base = self.flow.base(context)
        shares = base.logits.softmax(dim=-1).cumsum(dim=-1)  # (N, 1, M)
        component, normal = (values.to(poses.device) for values in latents)
        picked = (shares[..., :-1] < component[..., None]).sum(dim=-1)  # (N, K)
        index = picked[..., None].expand(-1, -1, self.dof)
        centre, scale = (
            values.squeeze(1).gather(1, index) for values in (base.base.mean, base.base.stddev)
        )
        unit = self.flow.transform(context).inv(centre + scale * normal)
        inside = (unit / HALF_WIDTH).clamp(-1, 1)
        return self.joint_centre + self.joint_scale * inside

    def context(self, poses: Tensor, noise: Tensor) -> Tensor:
        """Return what the couplings know (N, width) of poses (N, 7) and noise (N, 1)."""
        pose = matrix_pose(self.scaled(poses), poses[:, 3:])
        values = self.blocks(self.entry(torch.cat((pose, 2 * noise - 1), dim=1)))
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
