"""A differentiable penalty on configurations whose links come too near to each other."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from torch import Tensor

from robots import Robot
from robots.clearance_kernel import new_room, place, push_away
from robots.compiled import njit


class SelfClearance:
    """Half the sum of squares of what pairs of links lack of a clearance, in units of it.

    Pairs with a mesh do not count: only an exact library knows their distance. The robot's own
    shapes are looked at by compiled code, on one thread of the processor.

    Args:
        robot: The robot.
        clearance: Distance below which a pair of links is pushed apart [m].

    Raises:
        UrdfError: A collision shape cannot be used.
        ObstacleError: A joint of the chain moves the base.
    """

    def __init__(self, robot: Robot, clearance: float) -> None:
        self.scene, self.clearance = robot.clearance.scene, clearance

    def __call__(self, joints: Tensor) -> Tensor:
        """Return penalties (N,) of joints (N, dof) [rad or m]."""
        penalties: Tensor = _Missing.apply(joints, self)
        return penalties


class _Missing(torch.autograd.Function):
    """The penalties; their gradient comes from the same pass."""

    @staticmethod
    def forward(ctx: Any, joints: Tensor, goal: SelfClearance) -> Tensor:
        values = joints.detach().to(torch.float64).numpy()
        penalties = np.empty(len(values), dtype=np.float32)
        gradients = np.empty(values.shape, dtype=np.float32)
        room = new_room(goal.scene, 0)
        _measure(goal.scene, room, values, goal.clearance, penalties, gradients)
        ctx.save_for_backward(torch.from_numpy(gradients))
        return torch.from_numpy(penalties)

    @staticmethod
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor, None]:
        (slopes,) = ctx.saved_tensors
        return gradients[0].unsqueeze(1) * slopes, None


@njit(nogil=True)
def _measure(scene, room, joints, clearance, penalties, gradients):  # type: ignore[no-untyped-def]
    """Write penalties (N,) of joints (N, dof) and their derivatives (N, dof)."""
    away = np.empty(joints.shape[1])
    for row in range(joints.shape[0]):
        place(scene, joints[row], room)
        squared, _ = push_away(scene, room, 0.0, clearance, away)
        penalties[row] = squared / (2.0 * clearance * clearance)
        for k in range(joints.shape[1]):
            gradients[row, k] = -away[k] / (clearance * clearance)
