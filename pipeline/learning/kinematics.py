"""Differentiable forward kinematics: joints to poses, with gradients that are finite everywhere."""

from __future__ import annotations

import torch
from torch import Tensor

from robots import Robot


class ForwardKinematics:
    """Tip pose of a robot as a torch function, on the chain of pytorch-kinematics.

    Args:
        robot: The robot; its chain is read once.
        device: Where the poses are computed.
        dtype: Precision; float32 is exact to about a micrometre.
    """

    def __init__(
        self, robot: Robot, device: str | torch.device = "cpu", dtype: torch.dtype = torch.float32
    ) -> None:
        self._chain = robot.torch_chain(dtype=dtype, device=str(device))

    def __call__(self, joints: Tensor) -> Tensor:
        """Return poses (N, 7) in metres and unit quaternions (scalar first) of joints (N, dof)."""
        matrix = self._chain.forward_kinematics(joints).get_matrix()
        return torch.cat((matrix[:, :3, 3], quaternion_from_matrix(matrix[:, :3, :3])), dim=1)


def quaternion_from_matrix(rotation: Tensor) -> Tensor:
    """Return unit quaternions (N, 4), scalar first, of rotation matrices (N, 3, 3).

    Of the four textbook formulas the one with the largest denominator is taken for each matrix
    (Shepperd, *Quaternion from rotation matrix*, J. Guidance and Control 1(3), 1978). All of them
    share one symmetric matrix, so the choice is an index and no square root is ever taken near
    zero: gradients are finite at every rotation, half turns and the identity included.
    """
    m00, m11, m22 = rotation[:, 0, 0], rotation[:, 1, 1], rotation[:, 2, 2]
    off = torch.stack(
        (
            rotation[:, 2, 1] - rotation[:, 1, 2],
            rotation[:, 0, 2] - rotation[:, 2, 0],
            rotation[:, 1, 0] - rotation[:, 0, 1],
            rotation[:, 0, 1] + rotation[:, 1, 0],
            rotation[:, 0, 2] + rotation[:, 2, 0],
            rotation[:, 1, 2] + rotation[:, 2, 1],
        ),
        dim=1,
    )
    diagonal = 1 + torch.stack(
        (m00 + m11 + m22, m00 - m11 - m22, m11 - m00 - m22, m22 - m00 - m11), dim=1
    )
    best = diagonal.detach().argmax(dim=1)  # 4 times the square of that component, at least 1
    columns = _COLUMNS.to(rotation.device)[best]
    row = torch.cat((off, torch.gather(diagonal, 1, best[:, None])), dim=1).gather(1, columns)
    return row / torch.linalg.vector_norm(row, dim=1, keepdim=True)


# Row k: where the components of 4 q_k q stand, 0-5 in the off-diagonal terms and 6 on the diagonal.
_COLUMNS = torch.tensor([[6, 0, 1, 2], [0, 6, 3, 4], [1, 3, 6, 5], [2, 4, 5, 6]])
