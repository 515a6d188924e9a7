"""IKNet: the density of joints as a chain of densities of one joint given the former ones.

Bensadoun, Gur, Blau, Shenkar and Wolf, *Neural Inverse Kinematics*, ICML 2022. A hypernetwork f
takes the pose and returns the weights of primary networks g_1 ... g_n. Each g_i takes the joints
before the i-th and returns a mixture of Gaussians of its angle.
"""

from __future__ import annotations

from math import log, sqrt
from typing import NamedTuple

import torch
from torch import Tensor, nn
from torch.distributions import Categorical, MixtureSameFamily, Normal

from pipeline.learning.iknet.config import IkNetModel
from pipeline.learning.networks import MATRIX_POSE_SIZE, SamplingNetwork, perceptron
from robots import Robot

LEAST_SCALE = 1e-3  # of half a joint's range: a likelihood without a floor has no bound


class Primary(NamedTuple):
    """Weights of the primary networks of N poses, biases in their last columns.

    Attributes:
        first: (N, dof, width, dof + 1) from the joints and a constant to the hidden layer; zero for
            the joint itself and those behind it.
        second: (N, dof, 3 components, width + 1) from there to the mixture.
    """

    first: Tensor
    second: Tensor


class IkNet(SamplingNetwork):
    """The hypernetwork, and draws by the primary networks that it makes.

    Args:
        robot: The robot.
        model: Neurons of the hypernetwork (`hidden`) and of the hidden layer of each primary
            network (`width`), embedding, components.
    """

    before: Tensor

    def __init__(self, robot: Robot, model: IkNetModel) -> None:
        dof = robot.dof
        super().__init__(robot, normals=dof, choices=dof)
        self.forward_weight = model.forward_weight
        self.width, self.components = model.width, model.components
        self.trunk = perceptron([MATRIX_POSE_SIZE, *model.hidden, model.embedding], nn.ReLU)
        self.first = nn.Linear(model.embedding, dof * self.width * (dof + 1))
        self.second = nn.Linear(model.embedding, dof * 3 * self.components * (self.width + 1))
        before = torch.ones(dof, dof + 1).tril(-1)
        before[:, -1] = 1
        self.register_buffer("before", before.unsqueeze(1))
        self._scatter()

    def primary(self, poses: Tensor) -> Primary:
        """Return the weights of the primary networks for poses (N, 7)."""
        embedding = torch.relu(self.trunk(self.described(poses)))
        first = self.first(embedding).unflatten(1, (self.dof, self.width, self.dof + 1))
        second = self.second(embedding)
        shape = (self.dof, 3 * self.components, self.width + 1)
        return Primary(first * self.before, second.unflatten(1, shape))

    def log_likelihood(self, poses: Tensor, joints: Tensor) -> Tensor:
        """Return the log-densities (N, dof) of each joint, scaled to [-1, 1], given those before.

        Args:
            poses: (N, 7) metres and unit quaternions, scalar first.
            joints: (N, dof) rad or m.
        """
        weights, unit = self.primary(poses), self.unit(joints)
        hidden = torch.relu(torch.einsum("njwi,ni->njw", weights.first, _with_constant(unit)))
        values = torch.einsum("njmw,njw->njm", weights.second, _with_constant(hidden))
        return _mixture(values).log_prob(unit)

    def draws(self, poses: Tensor, latents: Tensor) -> Tensor:
        """See `SamplingNetwork.draws`: joint after joint, each inside its limits."""
        weights = self.primary(poses)
        normals, choices = latents.to(poses.device).split(self.dof, dim=2)
        unit = poses.new_zeros(len(poses), latents.shape[1], self.dof)
        drawn: list[Tensor] = []
        for joint in range(self.dof):
            inputs = _with_constant(unit)
            hidden = torch.relu(inputs @ weights.first[:, joint].mT)
            values = _with_constant(hidden) @ weights.second[:, joint].mT
            drawn.append(_drawn(values, normals[..., joint], choices[..., joint]))
            unit = torch.stack(drawn, dim=2)
            unit = nn.functional.pad(unit, (0, self.dof - 1 - joint))
        return self.inside(unit)

    def _scatter(self) -> None:
        """Begin with primary networks of usual weights, means apart, alike for all poses."""
        with torch.no_grad():
            for head, inputs in ((self.first, self.dof), (self.second, self.width)):
                head.weight.mul_(0.3 / sqrt(inputs))
                head.bias.normal_(std=1 / sqrt(inputs))
            shape = (self.dof, 3, self.components, self.width + 1)
            constants = self.second.bias.view(shape)[..., -1]
            constants[:, 0] = 0
            constants[:, 1].uniform_(-1, 1)
            constants[:, 2] = log(0.5)


def _with_constant(values: Tensor) -> Tensor:
    return nn.functional.pad(values, (0, 1), value=1.0)


def _mixture(values: Tensor) -> MixtureSameFamily:
    """Return mixtures of Gaussians from logits, means and logarithms of scales (..., 3 M)."""
    logits, mean, log_scale = values.chunk(3, dim=-1)
    scale = LEAST_SCALE + log_scale.clamp(max=2.0).exp()
    return MixtureSameFamily(
        Categorical(logits=logits, validate_args=False),
        Normal(mean, scale, validate_args=False),
        validate_args=False,
    )


def _drawn(values: Tensor, normal: Tensor, choice: Tensor) -> Tensor:
    """Draw (N, K) in [-1, 1] from mixtures (N, K, 3 M); differentiable for the component drawn."""
    mixture = _mixture(values)
    shares = mixture.mixture_distribution.probs.cumsum(dim=-1)
    index = (shares[..., :-1] < choice[..., None]).sum(dim=-1, keepdim=True)
    parts = mixture.component_distribution
    mean, scale = parts.mean.gather(-1, index), parts.stddev.gather(-1, index)
    return (mean.squeeze(-1) + scale.squeeze(-1) * normal).clamp(-1, 1)
