"""Loss of the cycle and its gradient in joint space in closed form, as few tensor operations.

Autograd through a chain of frames is several hundred small kernels a step, which a GPU takes longer
to start than to run. Here all frames come from one batched product and a parallel prefix product,
and the gradient from the geometric Jacobian: a force f and a torque t at the tip give
dL/dq = z . (t + (p - o) x f) for a turning joint with axis z and origin o, and z . f for a sliding
one (Siciliano et al., *Robotics*, section 3.1).
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import Tensor

from pipeline.learning.config import TrainConfig
from pipeline.learning.rotation import matrix_from_quaternion, quaternion_from_matrix
from robots.chain import Chain


class FusedCycleLoss:
    """Losses of joint values against poses by row, with gradients, on any device.

    Args:
        chain: The robot's chain.
        train: Names the losses, their betas and weights.
        device: Where joints and poses lie.
        dtype: Precision.
    """

    def __init__(
        self,
        chain: Chain,
        train: TrainConfig,
        device: torch.device,
        dtype: torch.dtype = torch.float32,
    ) -> None:
        def constant(values: Any) -> Tensor:
            return torch.as_tensor(np.asarray(values), device=device).to(dtype)

        self.train = train
        count = len(chain.prismatic)
        slides = np.asarray(chain.prismatic, dtype=float)
        select = np.zeros((count, len(chain.lower)))
        select[np.arange(count), chain.variable] = chain.multiplier
        self._select, self._offset = constant(select), constant(chain.offset)
        self._slides, self._turns = constant(slides), constant(1.0 - slides)
        self._basis = constant(_basis(chain))
        tip = np.eye(4)
        tip[:3, :3], tip[:3, 3] = chain.rotations[-1], chain.translations[-1]
        self._tip = constant(tip)
        self._ones = constant(np.ones(()))

    def frames(self, joints: Tensor) -> tuple[Tensor, Tensor]:
        """Return frames of the driven joints (m, N, 4, 4) and of the tip (N, 4, 4), base frame.

        Args:
            joints: (N, dof) rad or m.
        """
        values = self._select @ joints.T + self._offset[:, None]
        angles = values * self._turns[:, None]
        terms = (
            self._ones.expand_as(angles),
            angles.cos(),
            angles.sin(),
            values * self._slides[:, None],
        )
        frames = torch.bmm(torch.stack(terms, dim=2), self._basis).unflatten(2, (4, 4))
        shift = 1
        while shift < len(frames):
            frames = torch.cat((frames[:shift], frames[:-shift] @ frames[shift:]))
            shift *= 2
        return frames, frames[-1] @ self._tip

    def rows(self, joints: Tensor, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return losses (N,) and their gradients (N, dof) in joint space.

        Args:
            joints: (N, dof) rad or m.
            poses: (N, 7) targets, m and unit quaternions, scalar first, w >= 0.
        """
        frames, tip = self.frames(joints)
        position, rotation = tip[:, :3, 3], tip[:, :3, :3]
        moved, force = self._position(position, poses[:, :3])
        turned, torque = self._rotation(rotation, poses[:, 3:])
        train = self.train
        force, torque = train.position_weight * force, train.rotation_weight * torque
        axes, origins = frames[:, :, :3, 2], frames[:, :, :3, 3]
        arms = position - origins
        push = force.expand_as(arms)
        twist = torque + torch.linalg.cross(arms, push)
        effect = torch.lerp(twist, push, self._slides[:, None, None])
        gradient = ((axes * effect).sum(2).T) @ self._select
        return train.position_weight * moved + train.rotation_weight * turned, gradient

    def __call__(self, joints: Tensor, poses: Tensor) -> Tensor:
        """Return the mean loss of a batch, whose backward pass is the closed form."""
        loss: Tensor = _MeanLoss.apply(joints, poses, self)
        return loss

    def _position(self, position: Tensor, goal: Tensor) -> tuple[Tensor, Tensor]:
        """Position loss (N,) and its gradient (N, 3)."""
        error = position - goal
        if self.train.loss == "former":
            return error.abs().mean(1), error.sign() / 3
        loss, slope = _smooth_l1(error, self.train.position_beta)
        return loss.mean(1), slope / 3

    def _rotation(self, rotation: Tensor, goal: Tensor) -> tuple[Tensor, Tensor]:
        """Rotation loss (N,) and its torque (N, 3): its gradient by a turn of the tip."""
        beta = self.train.rotation_beta
        if self.train.loss == "matrix":
            loss, slope = _smooth_l1(rotation - matrix_from_quaternion(goal), beta)
            return loss.mean((1, 2)), torch.linalg.cross(rotation, slope, dim=1).sum(2) / 9
        q = quaternion_from_matrix(rotation)
        if self.train.loss == "former":
            q = torch.where(q[:, :1] < 0, -q, q)
            error = q - goal
            return error.abs().mean(1), _torque(q, error.sign() / 4)
        near, near_slope = _smooth_l1(q - goal, beta)
        far, far_slope = _smooth_l1(q + goal, beta)
        near, far = near.sum(1), far.sum(1)
        slope = torch.where((near <= far)[:, None], near_slope, far_slope)
        return torch.minimum(near, far), _torque(q, slope)


class _MeanLoss(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, joints: Tensor, poses: Tensor, cycle: FusedCycleLoss) -> Tensor:
        losses, gradient = cycle.rows(joints.detach(), poses)
        ctx.save_for_backward(gradient)
        return losses.mean()

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor, None, None]:
        (gradient,) = ctx.saved_tensors
        return gradient * (gradients[0] / len(gradient)), None, None


def _smooth_l1(error: Tensor, beta: float) -> tuple[Tensor, Tensor]:
    """Smooth L1 of errors and its derivative, the error over beta within [-1, 1]."""
    slope = (error / beta).clamp(-1.0, 1.0)
    return slope * (error - (0.5 * beta) * slope), slope


def _torque(q: Tensor, slope: Tensor) -> Tensor:
    """Gradient (N, 3) by a turn w of the base frame, where q changes by (0, w) q / 2.

    Args:
        q: (N, 4) unit quaternions, scalar first.
        slope: (N, 4) gradient by the quaternion.
    """
    vector, pull = q[:, 1:], slope[:, 1:]
    turned = torch.linalg.cross(vector, pull, dim=1)
    return 0.5 * (q[:, :1] * pull - slope[:, :1] * vector + turned)


def _basis(chain: Chain) -> np.ndarray:
    """(m, 4, 16) such that (1, cos, sin, shift) @ basis is F Z(q), row by row."""
    count = len(chain.prismatic)
    basis = np.zeros((count, 4, 4, 4))
    for index in range(count):
        turn, origin = chain.rotations[index], chain.translations[index]
        if chain.prismatic[index]:
            basis[index, 0, :3, :3] = turn
            basis[index, 3, :3, 3] = turn[:, 2]
        else:
            basis[index, 0, :3, 2] = turn[:, 2]
            basis[index, 1, :3, 0], basis[index, 1, :3, 1] = turn[:, 0], turn[:, 1]
            basis[index, 2, :3, 0], basis[index, 2, :3, 1] = turn[:, 1], -turn[:, 0]
        basis[index, 0, :3, 3] = origin
        basis[index, 0, 3, 3] = 1.0
    return basis.reshape(count, 4, 16)
