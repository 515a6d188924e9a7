"""Tip error and Jacobian of many configurations at once, in torch: any device, either precision.

What `baselines.linearise` computes for one configuration, computed for N of them by elementwise
products alone, so that a configuration's result does not depend on the batch around it. The batch
is the last axis: every product then runs along contiguous memory.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import torch
from torch import Tensor

if TYPE_CHECKING:
    from robots.chain import Chain

# Twice the sine of a rotation below which its axis is lost.
NO_AXIS = 1e-9


class Linearisation(NamedTuple):
    """The tip of N configurations, seen from its targets.

    Attributes:
        error: (6, N) from tip to target: distance [m], then rotation vector [rad], axes of the
            base.
        distance2: (N,) squared distance [m²].
        angle2: (N,) squared rotation angle [rad²].
        jacobian: (dof, 6, N) geometric Jacobian at the tip, transposed: one row a joint.
    """

    error: Tensor
    distance2: Tensor
    angle2: Tensor
    jacobian: Tensor


class Frames(NamedTuple):
    """What forward kinematics leaves behind for N configurations.

    Attributes:
        axes: (m, 3, N) joint axes in the base frame.
        origins: (m, 3, N) points on the joint axes in the base frame [m].
        rotation: (3, 3, N) of the tip, column by column: the first axis counts its columns.
        position: (3, N) of the tip [m].
    """

    axes: Tensor
    origins: Tensor
    rotation: Tensor
    position: Tensor


class TorchChain:
    """The constants of a `Chain` on a device.

    A joint and the constant transform behind it are cos A + sin B + D for a joint that turns, with
    the rows f of the constant transform: A = (f₀, f₁, 0), B = (-f₁, f₀, 0), D = (0, 0, f₂). For a
    sliding joint D is the whole transform and B, times the displacement, its shift along z.

    Args:
        chain: The chain.
        dtype: float32 or float64.
        device: Where it lies.
    """

    def __init__(self, chain: Chain, dtype: torch.dtype, device: torch.device) -> None:
        def constant(values: np.ndarray) -> Tensor:
            return torch.as_tensor(values, dtype=dtype, device=device)

        self.dof = len(chain.lower)
        rows = np.concatenate((chain.rotations, chain.translations[:, :, None]), axis=2)
        first, after = rows[0], rows[1:]
        cosine, sine, rest = np.zeros_like(after), np.zeros_like(after), np.zeros_like(after)
        turns = ~chain.prismatic
        cosine[turns, :2] = after[turns, :2]
        sine[turns, 0], sine[turns, 1] = -after[turns, 1], after[turns, 0]
        rest[turns, 2] = after[turns, 2]
        rest[~turns] = after[~turns]
        sine[~turns, 2, 3] = 1.0
        self.cosine, self.sine, self.rest = (constant(a[..., None]) for a in (cosine, sine, rest))
        self.first = constant(first.T[..., None])
        self.multiplier = constant(chain.multiplier[:, None])
        self.offset = constant(chain.offset[:, None])
        self.lower, self.upper = constant(chain.lower[:, None]), constant(chain.upper[:, None])
        self.variable = torch.as_tensor(chain.variable, device=device)
        self.sliding = (
            torch.as_tensor(chain.prismatic[:, None], device=device)
            if chain.prismatic.any()
            else None
        )
        # (dof, m): which joints a variable drives and how far; None where it is one joint each.
        drives = np.zeros((self.dof, len(chain.variable)))
        drives[chain.variable, np.arange(len(chain.variable))] = chain.multiplier
        self.drives = None if np.array_equal(drives, np.eye(self.dof)) else constant(drives)

    def frames(self, joints: Tensor) -> Frames:
        """Forward kinematics of joints (dof, N) in rad or m."""
        positions = self.multiplier * joints[self.variable] + self.offset
        sine, cosine = positions.sin(), positions.cos()
        if self.sliding is not None:
            sine = torch.where(self.sliding, positions, sine)
        local = torch.addcmul(self.rest, self.cosine, cosine[:, None, None])
        local.addcmul_(self.sine, sine[:, None, None])  # (m, 3 rows, 4 columns, N)
        frame = self.first.expand(4, 3, joints.shape[1])  # columns x y z and the origin
        axes, origins = [], []
        for part in local.unsqueeze(3):
            x, y, z, origin = frame
            axes.append(z)
            origins.append(origin)
            frame = x * part[0]
            frame.addcmul_(y, part[1]).addcmul_(z, part[2])
            frame[3] += origin
        return Frames(torch.stack(axes), torch.stack(origins), frame[:3], frame[3])

    def linearise(self, joints: Tensor, goal: Tensor, target: Tensor) -> Linearisation:
        """Error and Jacobian of joints (dof, N).

        Args:
            joints: (dof, N) rad or m.
            goal: (3, 3, N) rotation of the target, column by column.
            target: (3, N) position of the target [m].
        """
        at = self.frames(joints)
        distance = target - at.position
        turn, angle = rotation_vector(at.rotation, goal)
        error = torch.cat((distance, turn))
        return Linearisation(error, (distance * distance).sum(0), angle * angle, self.jacobian(at))

    def jacobian(self, at: Frames) -> Tensor:
        """Geometric Jacobian (dof, 6, N) at the tip, axes of the base, one row a joint."""
        moment = torch.linalg.cross(at.axes, at.position - at.origins, dim=1)
        turning = at.axes
        if self.sliding is not None:
            slides = self.sliding[:, None]
            moment = torch.where(slides, at.axes, moment)
            turning = torch.where(slides, 0.0, at.axes)
        rows = torch.cat((moment, turning), dim=1)
        if self.drives is None:
            return rows
        return (self.drives @ rows.flatten(1)).unflatten(1, rows.shape[1:])


def rotation_vector(rotation: Tensor, goal: Tensor) -> tuple[Tensor, Tensor]:
    """Rotation vector (3, N) from one frame to another in axes of the base, and its angle (N,).

    The formula is that of `baselines.linearise.find_error`, half turns included.

    Args:
        rotation: (3, 3, N) where the tip is, column by column.
        goal: (3, 3, N) where it should be, column by column.
    """
    sines = torch.linalg.cross(rotation, goal, dim=1).sum(0)
    cosine = (rotation * goal).sum((0, 1)) - 1.0
    sine = torch.linalg.vector_norm(sines, dim=0)
    angle = torch.atan2(sine, cosine)
    has_axis = sine > NO_AXIS
    vector = sines * torch.where(has_axis, angle / sine, 0.5)
    # Half a turn: any axis does to get away from here, the next step knows better.
    half = ~has_axis & (cosine <= 0.0)
    vector = torch.where(half, 0.0, vector)
    vector[0] = torch.where(half, math.pi, vector[0])
    return vector, angle


def target_frames(poses: Tensor) -> tuple[Tensor, Tensor]:
    """Rotations (3, 3, N), column by column, and positions (3, N) of poses (N, 7)."""
    x, y, z = poses[:, 4], poses[:, 5], poses[:, 6]
    w = poses[:, 3]
    columns = (
        1 - 2 * (y * y + z * z),
        2 * (x * y + w * z),
        2 * (x * z - w * y),
        2 * (x * y - w * z),
        1 - 2 * (x * x + z * z),
        2 * (y * z + w * x),
        2 * (x * z + w * y),
        2 * (y * z - w * x),
        1 - 2 * (x * x + y * y),
    )
    return torch.stack(columns).unflatten(0, (3, 3)), poses[:, :3].T.contiguous()
