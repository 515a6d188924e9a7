"""Rotations as torch tensors, scalar first, with gradients that are finite everywhere."""

from __future__ import annotations

from functools import cache

import torch
from torch import Tensor

# Row k: where the components of 4 q_k q stand, 0-5 in the off-diagonal terms and 6 on the diagonal.
COLUMNS = ((6, 0, 1, 2), (0, 6, 3, 4), (1, 3, 6, 5), (2, 4, 5, 6))


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
    columns = _columns(rotation.device)[best]
    row = torch.cat((off, torch.gather(diagonal, 1, best[:, None])), dim=1).gather(1, columns)
    return row / torch.linalg.vector_norm(row, dim=1, keepdim=True)


def matrix_from_quaternion(quaternion: Tensor) -> Tensor:
    """Return rotation matrices (N, 3, 3) of unit quaternions (N, 4), scalar first; even in q."""
    w, x, y, z = quaternion.unbind(dim=1)
    rows = (
        1 - 2 * (y * y + z * z),
        2 * (x * y - w * z),
        2 * (x * z + w * y),
        2 * (x * y + w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z - w * x),
        2 * (x * z - w * y),
        2 * (y * z + w * x),
        1 - 2 * (x * x + y * y),
    )
    return torch.stack(rows, dim=1).unflatten(1, (3, 3))


@cache
def _columns(device: torch.device) -> Tensor:
    """`COLUMNS` on a device, copied there once: a step that is captured may not."""
    return torch.tensor(COLUMNS, device=device)
