"""A view that has a whole robot in the picture, for robots whose description gives none."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robots.viewpoints import Picture

if TYPE_CHECKING:
    from robots.robot import Robot

Array = NDArray[np.float64]

YAW_DEG, PITCH_DEG = 50.0, -15.0
# From the middle to the camera, in radii of what is in the picture: its angle of view is narrow.
RADII = 4.5
LEAST_RADIUS_M = 0.05


def default_view(robot: Robot, joints: Array) -> Picture:
    """A camera that sees the robot at one configuration and the reach of its tip.

    Args:
        robot: The robot.
        joints: (dof,) rad or m.
    """
    poses = robot.link_poses(joints)
    links = np.array([pose[:3, 3] for pose in poses.values()])
    low, high = robot.workspace
    corners = np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
    base = poses[robot.base]
    points = np.vstack([links, corners @ base[:3, :3].T + base[:3, 3]])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float((points.max(axis=0) - points.min(axis=0)).max()) / 2
    distance = RADII * max(radius, LEAST_RADIUS_M)
    return Picture(np.round(middle, 3), round(distance, 2), YAW_DEG, PITCH_DEG, 0)
