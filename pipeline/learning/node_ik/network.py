"""A continuous normalizing flow from noise to the joints that reach a pose.

Park, Schwartz and Park, *NODE IK: Solving Inverse Kinematics with Neural Ordinary Differential
Equations for Path Planning*, ICCAS 2022. The flow is that of FFJORD (Grathwohl et al., ICLR 2019):
joints x obey dx/dt = f(x, t, pose) from noise at t = 0 to solutions at t = 1, and

    log p(x(1)) = log N(x(0)) - integral over t of tr(df/dx).
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import torch
from torch import Tensor, nn

from pipeline.learning.networks import HALF_WIDTH, MATRIX_POSE_SIZE, SamplingNetwork
from pipeline.learning.node_ik.config import NodeIkModel
from robots import Robot


class Squash(NamedTuple):
    """What a layer knows of N poses, with axes for draws: gate and shift (N, 1, outputs)."""

    gate: Tensor
    shift: Tensor


class SquashLayer(nn.Module):
    """A layer whose outputs are gated and shifted by context and time (FFJORD's concatsquash).

    Args:
        inputs: Values that go in.
        outputs: Values that come out.
        context: Values that describe pose and noise.
    """

    def __init__(self, inputs: int, outputs: int, context: int) -> None:
        super().__init__()
        self.linear = nn.Linear(inputs, outputs)
        self.gate = nn.Linear(context, outputs)
        self.shift = nn.Linear(context, outputs, bias=False)
        self.gate_rate = nn.Parameter(torch.zeros(outputs))
        self.shift_rate = nn.Parameter(torch.zeros(outputs))

    def squash(self, context: Tensor) -> Squash:
        """Return the share of a context (N, C) in gate and shift: it is that of all times."""
        return Squash(self.gate(context).unsqueeze(1), self.shift(context).unsqueeze(1))

    def forward(
        self, values: Tensor, tangents: Tensor, known: Squash, time: float
    ) -> tuple[Tensor, Tensor]:
        """Return the values (N, K, outputs) and how they change along tangents (N, P, inputs)."""
        gate = torch.sigmoid(known.gate + time * self.gate_rate)
        shift = known.shift + time * self.shift_rate
        return self.linear(values) * gate + shift, (tangents @ self.linear.weight.mT) * gate


class NodeIk(SamplingNetwork):
    """The velocity of joints, and what follows from its integration: a density and draws.

    Args:
        robot: The robot.
        model: Neurons of the hidden layers, steps, probes, largest training noise.
    """

    def __init__(self, robot: Robot, model: NodeIkModel) -> None:
        super().__init__(robot, normals=robot.dof)
        self.steps, self.probes, self.noise = model.steps, model.probes, model.noise
        sizes = [robot.dof, *model.hidden, robot.dof]
        self.layers = nn.ModuleList(
            SquashLayer(inputs, outputs, MATRIX_POSE_SIZE + 1)
            for inputs, outputs in pairwise(sizes)
        )
        last = self.layers[-1]
        assert isinstance(last, SquashLayer)
        for part in (last.linear.weight, last.linear.bias, last.shift.weight):
            nn.init.zeros_(part)  # the flow starts as the identity

    def log_density(
        self, poses: Tensor, scaled: Tensor, share: Tensor, probes: Tensor
    ) -> tuple[Tensor, Tensor]:
        """Return the log-density (N,) of scaled joints, and the noise (N, dof) they come from.

        Args:
            poses: (N, 7) metres and unit quaternions, scalar first.
            scaled: (N, dof) joints of unit variance.
            share: (N, 1) in [0, 1], the share of the training noise that the joints carry.
            probes: (N, P, dof) directions v with mean of v vᵀ the identity; the trace is taken as
                the mean of vᵀ (df/dx) v (Hutchinson, 1989).
        """
        known = self._known(poses, share)
        start, change = self._integrate(scaled.unsqueeze(1), probes, known, 1.0, 0.0)
        noise = start.squeeze(1)
        normal = -0.5 * (noise.square() + math.log(2 * math.pi)).sum(dim=1)
        return normal + change, noise

    def transformed(self, poses: Tensor, noise: Tensor) -> Tensor:
        """Return scaled joints (N, K, dof) for poses (N, 7) and noise (N or 1, K, dof)."""
        known = self._known(poses, poses.new_zeros(len(poses), 1))
        noise = noise.to(poses.device).expand(len(poses), -1, -1)
        scaled, _ = self._integrate(noise, noise.new_zeros(1, 0, self.dof), known, 0.0, 1.0)
        return scaled

    def draws(self, poses: Tensor, latents: Tensor) -> Tensor:
        """See `SamplingNetwork.draws`; the noise of the training is switched off."""
        return self.inside(self.transformed(poses, latents) / HALF_WIDTH)

    def _known(self, poses: Tensor, share: Tensor) -> list[Squash]:
        context = torch.cat((self.described(poses), 2 * share - 1), dim=1)
        return [layer.squash(context) for layer in self._squash_layers()]

    def _squash_layers(self) -> list[SquashLayer]:
        return [layer for layer in self.layers if isinstance(layer, SquashLayer)]

    def _velocity(
        self, joints: Tensor, probes: Tensor, known: list[Squash], time: float
    ) -> tuple[Tensor, Tensor]:
        """Return the velocities of joints (N, K, dof), and the estimated trace (N,) at K = 1.

        The tangents are carried forwards beside the values, so that training needs one derivative
        of the estimate and not two.
        """
        values, tangents = joints, probes
        *hidden, last = zip(self._squash_layers(), known, strict=True)
        for layer, squash in hidden:
            values, tangents = layer(values, tangents, squash, time)
            values = torch.tanh(values)
            tangents = tangents * (1 - values.square()) if tangents.shape[1] else tangents
        velocity, tangents = last[0](values, tangents, last[1], time)
        trace = (tangents * probes).sum(dim=(1, 2)) / max(1, probes.shape[1])
        return velocity, trace

    def _integrate(
        self, joints: Tensor, probes: Tensor, known: list[Squash], begin: float, end: float
    ) -> tuple[Tensor, Tensor]:
        """Return the joints at the end and the integral of the trace, by fourth-order Runge-Kutta.

        Steps are of one size; the authors' solver adapts it.
        """
        step = (end - begin) / self.steps
        integral = joints.new_zeros(())
        for number in range(self.steps):
            time = begin + number * step
            k1, t1 = self._velocity(joints, probes, known, time)
            k2, t2 = self._velocity(joints + step / 2 * k1, probes, known, time + step / 2)
            k3, t3 = self._velocity(joints + step / 2 * k2, probes, known, time + step / 2)
            k4, t4 = self._velocity(joints + step * k3, probes, known, time + step)
            joints = joints + step / 6 * (k1 + 2 * (k2 + k3) + k4)
            integral = integral + step / 6 * (t1 + 2 * (t2 + t3) + t4)
        return joints, integral
