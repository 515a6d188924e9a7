"""A robot in PyBullet, to hold our kinematics and collision checks against another engine."""

from __future__ import annotations

from typing import Self

import numpy as np
import pybullet
from numpy.typing import NDArray

from robots import Robot

Array = NDArray[np.float64]


class Simulation:
    """A PyBullet client with one robot on a fixed base, in its posture at home.

    Cylinders are kept as cylinders; by default PyBullet would turn them into meshes.

    Attributes:
        client: Number of the client.
        body: Number of the body.
        joints: Number of each joint by its name.
        links: Number of each link by its name.
    """

    def __init__(self, robot: Robot) -> None:
        self.robot = robot
        self.client = pybullet.connect(pybullet.DIRECT)
        self.body = pybullet.loadURDF(
            str(robot.urdf_path),
            useFixedBase=True,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER,
            physicsClientId=self.client,
        )
        self.joints: dict[str, int] = {}
        self.links = {pybullet.getBodyInfo(self.body, self.client)[0].decode(): -1}
        for index in range(pybullet.getNumJoints(self.body, self.client)):
            info = pybullet.getJointInfo(self.body, index, self.client)
            self.joints[info[1].decode()], self.links[info[12].decode()] = index, index
        for name, position in robot.description.posture.items():
            self._set(name, position)
        self.move(robot.home)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pybullet.disconnect(self.client)

    def move(self, joints: Array) -> None:
        """Put the chain at joints (dof,) without dynamics."""
        for name, position in zip(self.robot.joint_names, joints, strict=True):
            self._set(name, position)

    def gap(self, within: float) -> float:
        """Return the least distance of the checked pairs, negative in contact, m.

        Args:
            within: Pairs farther apart than this are not looked at; it is returned then.
        """
        return min(
            (
                point[8]
                for first, second in self.robot.collision.pairs
                for point in pybullet.getClosestPoints(
                    self.body,
                    self.body,
                    within,
                    self.links[first],
                    self.links[second],
                    physicsClientId=self.client,
                )
            ),
            default=within,
        )

    def _set(self, name: str, position: float) -> None:
        pybullet.resetJointState(
            self.body, self.joints[name], position, physicsClientId=self.client
        )
