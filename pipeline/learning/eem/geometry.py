"""A robot as points: two on the axis of each joint, three on base and tip; and joints from them.

The representation is that of distance geometry (Maric, Giamou, Hall, Khoubyarian, Petrovic and
Kelly, *Riemannian Optimization for Distance-Geometric Inverse Kinematics*, IEEE T-RO 38(3), 2022):
distances of points on one link are constants of the robot, and joint angles follow from points.
"""

from __future__ import annotations

import math
from typing import Any

import torch
from torch import Tensor, nn

from pipeline.learning.rotation import matrix_from_quaternion
from robots import Robot

AXIS = 0.3  # from a point to the second one on its axis, in units of the reach
PROBED = 24  # random configurations that show what is constant
CONSTANT = 1e-4  # of the reach, below which a distance does not change
BASE, TIP = slice(0, 3), slice(-3, None)  # origin, a point on x, a point on y


class PointGraph(nn.Module):
    """Points of a robot, which of them a pose determines, and their constant distances.

    Order: three of the base, two of each joint from base to tip (on its axis at the frame's origin
    and further along), three of the tip. Lengths are in units of the reach, the base at the origin.

    Args:
        robot: The robot; joints that slide or are coupled included.

    Attributes:
        kinds: (P, 9) what a point is, one of eight, and where in the chain, from 0 to 1.
        edges: (P, P, 2) whether a distance is constant, and that distance, else 0.
        unknown: (U,) indices of the points that a pose does not determine.
        scale: The reach [m].
    """

    kinds: Tensor
    edges: Tensor
    unknown: Tensor
    rotations: Tensor
    translations: Tensor
    attached: Tensor
    at_base: Tensor
    at_tip: Tensor
    fixed: Tensor
    centre: Tensor
    line: Tensor

    def __init__(self, robot: Robot) -> None:
        super().__init__()
        chain = robot.chain
        self.scale = float(abs(robot.workspace).max())
        self.dof, self.prismatic = robot.dof, chain.prismatic.tolist()
        self.variable, self.offset = chain.variable.tolist(), chain.offset.tolist()
        self.multiplier = chain.multiplier.tolist()
        self._keep("rotations", chain.rotations)
        self._keep("translations", chain.translations / self.scale)
        self._keep("centre", (robot.lower + robot.upper) / 2)
        self._keep("kinds", self._kinds())
        self._keep("attached", self._attached())
        self._find_constants(robot)

    @property
    def count(self) -> int:
        """Points P."""
        return 2 * len(self.prismatic) + 6

    def points(self, joints: Tensor) -> Tensor:
        """Return the points (N, P, 3) of joints (N, dof) in rad or m."""
        position = self.translations[0].expand(len(joints), 3)
        rotation = self.rotations[0].expand(len(joints), 3, 3)
        origin = torch.eye(3, device=joints.device).expand(len(joints), 3, 3)
        found = [*_frame_points(torch.zeros_like(position), origin)]
        for index in range(len(self.prismatic)):
            found += [position, position + AXIS * rotation[:, :, 2]]
            value = self.multiplier[index] * joints[:, self.variable[index]] + self.offset[index]
            position, rotation = self._advanced(position, rotation, value, index)
        found += _frame_points(position, rotation)
        return torch.stack(found, dim=1)

    def given(self, poses: Tensor) -> Tensor:
        """Return points (N, P, 3) as far as poses (N, 7) tell, others between base and tip."""
        position, rotation = poses[:, :3] / self.scale, matrix_from_quaternion(poses[:, 3:])
        at_tip = position.unsqueeze(1) + self.at_tip @ rotation.mT
        at_base = self.at_base.expand_as(at_tip)
        between = self.line * position.unsqueeze(1)
        kind = self.fixed[None, :, None].expand_as(at_tip)
        return torch.where(kind == 1, at_base, torch.where(kind == 2, at_tip, between))

    def joints(self, points: Tensor) -> Tensor:
        """Return joints (N, dof) in rad or m whose links lie nearest to points (N, P, 3).

        From the base on: the angle of a joint is the one that turns what is fixed to its link about
        its axis nearest to where it is (planar Procrustes); a joint that slides takes the mean way.
        """
        position = self.translations[0].expand(len(points), 3)
        rotation = self.rotations[0].expand(len(points), 3, 3)
        found: dict[int, Tensor] = {}
        for index in range(len(self.prismatic)):
            variable = self.variable[index]
            if variable not in found:
                found[variable] = self._value(points, position, rotation, index)
            value = self.multiplier[index] * found[variable] + self.offset[index]
            position, rotation = self._advanced(position, rotation, value, index)
        return torch.stack([found[index] for index in range(self.dof)], dim=1)

    def _value(self, points: Tensor, position: Tensor, rotation: Tensor, index: int) -> Tensor:
        """Return a joint (N,) from the points on its link, seen from its frame."""
        first = 3 + 2 * (index + 1)
        count = 3 if index == len(self.prismatic) - 1 else 2
        local = (points[:, first : first + count] - position.unsqueeze(1)) @ rotation
        known = self.attached[index, :count]
        if self.prismatic[index]:
            value = (local[..., 2] - known[:, 2]).mean(dim=1) * self.scale
            return (value - self.offset[index]) / self.multiplier[index]
        sine = (known[:, 0] * local[..., 1] - known[:, 1] * local[..., 0]).sum(dim=1)
        cosine = (known[:, 0] * local[..., 0] + known[:, 1] * local[..., 1]).sum(dim=1)
        value = (torch.atan2(sine, cosine) - self.offset[index]) / self.multiplier[index]
        turn = 2 * math.pi / abs(self.multiplier[index])
        middle = self.centre[self.variable[index]]
        return middle + torch.remainder(value - middle + turn / 2, turn) - turn / 2

    def _advanced(
        self, position: Tensor, rotation: Tensor, value: Tensor, index: int
    ) -> tuple[Tensor, Tensor]:
        """Return the frame of the next joint, or of the tip, behind a joint of a value (N,)."""
        x, y, z = rotation.unbind(dim=2)
        value = value.unsqueeze(1)
        if self.prismatic[index]:
            position = position + z * value / self.scale
        else:
            cosine, sine = value.cos(), value.sin()
            rotation = torch.stack((x * cosine + y * sine, y * cosine - x * sine, z), dim=2)
        position = position + rotation @ self.translations[index + 1]
        return position, rotation @ self.rotations[index + 1]

    def _attached(self) -> Tensor:
        """Return what is fixed to each link (n, 3, 3), in its joint's frame at zero, 0 behind."""
        attached = torch.zeros(len(self.prismatic), 3, 3)
        for index in range(len(self.prismatic)):
            place, turn = self.translations[index + 1], self.rotations[index + 1]
            if index < len(self.prismatic) - 1:
                attached[index, 0], attached[index, 1] = place, place + AXIS * turn[:, 2]
            else:
                attached[index] = torch.stack(_frame_points(place[None], turn[None]))[:, 0]
        return attached

    def _kinds(self) -> Tensor:
        number = len(self.prismatic)
        kinds = [0, 1, 2, *([3, 4] * number), 5, 6, 7]
        places = [0.0] * 3 + [(i // 2 + 1) / (number + 1) for i in range(2 * number)] + [1.0] * 3
        hot = nn.functional.one_hot(torch.tensor(kinds), 8).float()
        place = torch.tensor(places).unsqueeze(1)
        self._keep("line", place)
        return torch.cat((hot, place), dim=1)

    def _find_constants(self, robot: Robot) -> None:
        """Look at random configurations: constant distances, points fixed to base and to tip."""
        drawn = robot.sample(PROBED, seed=0, collision_free=False)
        points = self.points(torch.as_tensor(drawn, dtype=torch.float32))
        apart = torch.linalg.vector_norm(points[:, :, None] - points[:, None], dim=3)
        constant = (apart.amax(0) - apart.amin(0)) < CONSTANT
        self._keep("edges", torch.stack((constant.float(), constant * apart.mean(0)), dim=2))
        corner = points[:, TIP] - points[:, -3:-2]
        x, y = corner[:, 1] / AXIS, corner[:, 2] / AXIS
        turn = torch.stack((x, y, torch.linalg.cross(x, y, dim=1)), dim=2)
        seen = (points - points[:, -3:-2]) @ turn
        self._keep("at_base", points.mean(0))
        self._keep("at_tip", seen.mean(0))
        steady = [((p.amax(0) - p.amin(0)) < CONSTANT).all(dim=1) for p in (points, seen)]
        fixed = torch.where(steady[0], 1, torch.where(steady[1], 2, 0))
        self._keep("fixed", fixed)
        self._keep("unknown", (fixed == 0).nonzero().squeeze(1))

    def _keep(self, name: str, values: Any) -> None:
        """Keep a constant of the robot, which is no part of the weights on disk."""
        tensor = torch.as_tensor(values)
        tensor = tensor.float() if tensor.is_floating_point() else tensor
        self.register_buffer(name, tensor, persistent=False)


def _frame_points(position: Tensor, rotation: Tensor) -> list[Tensor]:
    """Return the origin of frames (N, 3), a point on their x and one on their y."""
    return [position, position + AXIS * rotation[:, :, 0], position + AXIS * rotation[:, :, 1]]
