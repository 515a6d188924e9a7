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

    Attributes:
        client: Number of the client.
        body: Number of the body.
        joints: Number of each joint by its name.
        links: Number of each link by its name.
        pairs: Numbers of the two links of each pair that is checked for collisions.
    """

    def __init__(self, robot: Robot, flags: int = pybullet.URDF_USE_IMPLICIT_CYLINDER) -> None:
        """Load a robot.

        Args:
            robot: The robot.
            flags: How PyBullet reads the URDF, besides taking its inertias; by default cylinders
                stay cylinders, without a flag they become meshes.
        """
        self.robot = robot
        self.client = pybullet.connect(pybullet.DIRECT)
        self.body = pybullet.loadURDF(
            str(robot.urdf_path),
            useFixedBase=True,
            flags=pybullet.URDF_USE_INERTIA_FROM_FILE | flags,
            physicsClientId=self.client,
        )
        self.joints: dict[str, int] = {}
        self.links = {pybullet.getBodyInfo(self.body, self.client)[0].decode(): -1}
        for index in range(pybullet.getNumJoints(self.body, self.client)):
            info = pybullet.getJointInfo(self.body, index, self.client)
            self.joints[info[1].decode()], self.links[info[12].decode()] = index, index
        for name, position in robot.description.posture.items():
            self._set(name, position)
        self.pairs = [(self.links[a], self.links[b]) for a, b in robot.collision.pairs]
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

        These are PyBullet's own shapes, whose edges it rounds by a margin of 1 mm, inward.

        Args:
            within: Pairs farther apart than this are not looked at; it is returned then. Above 0:
                queried for contacts alone PyBullet overlooks boxes that touch, unless the body was
                loaded with `URDF_USE_SELF_COLLISION`.
        """
        body = self.body
        points = (
            point
            for a, b in self.pairs
            for point in pybullet.getClosestPoints(
                body, body, within, a, b, physicsClientId=self.client
            )
        )
        return min((point[8] for point in points), default=within)

    def _set(self, name: str, position: float) -> None:
        pybullet.resetJointState(
            self.body, self.joints[name], position, physicsClientId=self.client
        )


class SharpShapes:
    """Every collision shape of a simulated robot once more, as a body without rounded edges.

    PyBullet rounds edges and corners of a URDF's boxes and cylinders by a margin of 1 mm, inward,
    and lets only bodies of a single shape do without.

    Attributes:
        bodies: (link, body, position and orientation of the shape in the link's inertial frame).
        radii: (S,) of a sphere around the centre of each that holds it, m.
        pairs: (P, 2) rows of two bodies to check.
    """

    def __init__(self, simulation: Simulation) -> None:
        self.simulation = simulation
        client = simulation.client
        self.bodies = []
        radii = []
        for link in simulation.links.values():
            shapes = pybullet.getCollisionShapeData(simulation.body, link, client)
            for _, _, kind, size, _, position, orientation in shapes:
                shape = pybullet.createCollisionShape(
                    kind, physicsClientId=client, **_arguments(kind, size)
                )
                body = pybullet.createMultiBody(0.0, shape, physicsClientId=client)
                pybullet.changeDynamics(body, -1, collisionMargin=0.0, physicsClientId=client)
                self.bodies.append((link, body, position, orientation))
                radii.append(_radius(kind, size))
        self.radii = np.array(radii)
        pairs = set(simulation.pairs)
        self.pairs = np.array(
            [
                (i, j)
                for i, first in enumerate(self.bodies)
                for j, second in enumerate(self.bodies)
                if (first[0], second[0]) in pairs
            ]
        )

    def gap(self, within: float) -> float:
        """Return the least distance of the checked pairs, negative in contact, m.

        Args:
            within: Pairs farther apart than this are not looked at; it is returned then.
        """
        client = self.simulation.client
        centres = np.empty((len(self.bodies), 3))
        for row, (link, body, position, orientation) in enumerate(self.bodies):
            pose = pybullet.multiplyTransforms(*self._inertial(link), position, orientation)
            pybullet.resetBasePositionAndOrientation(body, *pose, physicsClientId=client)
            centres[row] = pose[0]
        apart = np.linalg.norm(np.subtract(*centres[self.pairs.T]), axis=1)
        near = self.pairs[apart < self.radii[self.pairs].sum(axis=1) + within]
        points = (
            point
            for i, j in near
            for point in pybullet.getClosestPoints(
                self.bodies[i][1], self.bodies[j][1], within, physicsClientId=client
            )
        )
        return min((point[8] for point in points), default=within)

    def _inertial(self, link: int) -> tuple[list[float], list[float]]:
        body, client = self.simulation.body, self.simulation.client
        if link < 0:
            return pybullet.getBasePositionAndOrientation(body, client)
        return pybullet.getLinkState(body, link, 0, 1, physicsClientId=client)[:2]


def _arguments(kind: int, size: tuple[float, float, float]) -> dict[str, object]:
    """Turn what `getCollisionShapeData` tells of a shape into what makes it again."""
    if kind == pybullet.GEOM_BOX:
        return {"halfExtents": [side / 2.0 for side in size]}
    if kind == pybullet.GEOM_CYLINDER:
        return {"height": size[0], "radius": size[1]}
    assert kind == pybullet.GEOM_SPHERE, f"no shape of kind {kind} is expected"
    return {"radius": size[0]}


def _radius(kind: int, size: tuple[float, float, float]) -> float:
    """Return the radius in m of the sphere that holds a shape, sizes as PyBullet tells them."""
    if kind == pybullet.GEOM_BOX:
        return float(np.linalg.norm(size)) / 2.0
    if kind == pybullet.GEOM_CYLINDER:
        return float(np.hypot(size[0] / 2.0, size[1]))
    return size[0]
