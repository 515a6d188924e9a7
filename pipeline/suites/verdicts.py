"""Two judges of collision, by libraries that share nothing: coal behind Pinocchio, and PyBullet.

Each places the robot by its own kinematics and measures with its own search. PyBullet rounds edges
and corners of a URDF's boxes by 1 mm, inward; so `TOLERANCE_MM` is the difference beyond which two
verdicts are a disagreement.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Self

import coal
import numpy as np
import pandas as pd
import pinocchio
import pybullet
from numpy.typing import NDArray

from robots import Obstacles
from robots.native_output import stdout_elsewhere

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

COLUMNS = {
    "requested_clearance_mm": "least distance from obstacles that counts as free [mm]",
    "coal_distance_mm": "of the nearest link that moves from the nearest obstacle, by coal [mm]",
    "coal_self_collision": "whether the robot collides with itself, by coal",
    "bullet_distance_mm": "the same distance by PyBullet [mm]",
    "bullet_self_gap_mm": "least distance of links that may not touch, by PyBullet [mm]",
}
MOST_MM = 100.0  # distances beyond are recorded as this
SELF_MOST_MM = 10.0  # the same of the robot from itself
TOLERANCE_MM = 1.0
MM_PER_M = 1e3


def verdicts(robot: Robot, joints: Array, obstacles: Sequence[Obstacles]) -> dict[str, Any]:
    """Return the columns of `COLUMNS` for answers.

    Args:
        robot: The robot.
        joints: (N, dof) [rad or m].
        obstacles: N sets in the base frame, each with the clearance that is requested.
    """
    coal_judge = CoalJudge(robot)
    with BulletJudge(robot) as bullet:
        pairs = list(zip(joints, obstacles, strict=True))
        return {
            "requested_clearance_mm": np.array([MM_PER_M * each.clearance_m for each in obstacles]),
            "coal_distance_mm": np.array([coal_judge.distance_mm(*pair) for pair in pairs]),
            "coal_self_collision": robot.collision.exact.in_collision(joints),
            "bullet_distance_mm": np.array([bullet.distance_mm(*pair) for pair in pairs]),
            "bullet_self_gap_mm": np.array([bullet.self_gap_mm(q) for q in joints]),
        }


def free_by_coal(rows: pd.DataFrame) -> NDArray[np.bool_]:
    """(N,) which answers coal finds free; rounding at the clearance itself is let pass."""
    clear = rows.coal_distance_mm >= rows.requested_clearance_mm - 1e-3
    return np.asarray(clear & ~rows.coal_self_collision.astype(bool))


def free_by_bullet(rows: pd.DataFrame) -> NDArray[np.bool_]:
    """(N,) which answers PyBullet finds free, its tolerance let pass."""
    clear = rows.bullet_distance_mm >= rows.requested_clearance_mm - TOLERANCE_MM
    return np.asarray(clear & (rows.bullet_self_gap_mm >= -TOLERANCE_MM))


def disagreements(rows: pd.DataFrame) -> NDArray[np.bool_]:
    """(N,) of which answers the judges measure distances that differ beyond the tolerance.

    Of overlaps the depth counts for nothing: an overlap is one whatever its depth.
    """
    coal_mm = rows.coal_distance_mm.clip(lower=0.0)
    bullet_mm = rows.bullet_distance_mm.clip(lower=0.0)
    apart = (coal_mm - bullet_mm).abs() > TOLERANCE_MM
    touching = rows.coal_self_collision.astype(bool)
    gap = rows.bullet_self_gap_mm
    own = (touching & (gap > TOLERANCE_MM)) | (~touching & (gap < -TOLERANCE_MM))
    return np.asarray(apart | own)


class CoalJudge:
    """Distances of the links of a robot that move from obstacles, by coal at Pinocchio's frames."""

    def __init__(self, robot: Robot) -> None:
        self._exact = robot.collision.exact
        objects = self._exact.geometry.geometryObjects
        self._moving = [row for row, each in enumerate(objects) if each.parentJoint != 0]
        for each in objects:
            each.geometry.computeLocalAABB()
        self._spheres = [
            (objects[row].geometry.aabb_center, objects[row].geometry.aabb_radius)
            for row in self._moving
        ]
        model = self._exact.model
        self._base = model.frames[model.getFrameId(robot.base, pinocchio.FrameType.BODY)].placement

    def distance_mm(self, joints: Array, obstacles: Obstacles) -> float:
        """Distance of the nearest moving link from the nearest obstacle [mm], below 0 in overlap.

        Args:
            joints: (dof,) [rad or m].
            obstacles: In the base frame.
        """
        placed, objects = self._exact.placed(joints), self._exact.geometry.geometryObjects
        best = MOST_MM / MM_PER_M
        for solid, place, radius in self._solids(obstacles):
            for row, (centre, reach) in zip(self._moving, self._spheres, strict=True):
                at = placed.oMg[row]
                offset = at.rotation @ centre + at.translation - place.getTranslation()
                if np.linalg.norm(offset) - reach - radius > best:
                    continue
                shape = objects[row].geometry
                here = coal.Transform3s(at.rotation, at.translation)
                request, result = coal.DistanceRequest(), coal.DistanceResult()
                best = min(best, coal.distance(shape, here, solid, place, request, result))
        return float(best * MM_PER_M)

    def _solids(self, obstacles: Obstacles) -> list[tuple[Any, Any, float]]:
        """Obstacles as coal has them: shape, placement in the root's frame, bounding radius [m]."""
        found = []
        for box in obstacles.boxes:
            w, x, y, z = box.orientation
            turn = pinocchio.Quaternion(w, x, y, z).normalized().toRotationMatrix()
            radius = float(np.linalg.norm(box.size)) / 2.0
            found.append((coal.Box(*box.size), self._placement(turn, box.position), radius))
        for sphere in obstacles.spheres:
            place = self._placement(np.eye(3), sphere.position)
            found.append((coal.Sphere(sphere.radius), place, sphere.radius))
        return found

    def _placement(self, rotation: Array, position: Sequence[float]) -> Any:
        place = self._base * pinocchio.SE3(rotation, np.array(position))
        return coal.Transform3s(place.rotation, place.translation)


class BulletJudge:
    """The same by a headless PyBullet, which reads the URDF itself."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        with stdout_elsewhere(shown=False):
            self._client = pybullet.connect(pybullet.DIRECT)
        flags = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER
        self._body = pybullet.loadURDF(
            str(robot.urdf_path), useFixedBase=True, flags=flags, physicsClientId=self._client
        )
        links = {pybullet.getBodyInfo(self._body, self._client)[0].decode(): -1}
        self._joints = {}
        for index in range(pybullet.getNumJoints(self._body, self._client)):
            info = pybullet.getJointInfo(self._body, index, self._client)
            self._joints[info[1].decode()], links[info[12].decode()] = index, index
        self._moving = {links[name] for name, frame in robot.bodies.frame.items() if frame >= 0}
        self._pairs = [(links[a], links[b]) for a, b in robot.collision.pairs]
        turn = pinocchio.Quaternion(robot.clearance.base[:3, :3])
        self._base = robot.clearance.base[:3, 3].tolist(), turn.coeffs().tolist()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pybullet.disconnect(self._client)

    def distance_mm(self, joints: Array, obstacles: Obstacles) -> float:
        """Distance of the nearest moving link from the nearest obstacle [mm], below 0 in overlap.

        Args:
            joints: (dof,) [rad or m].
            obstacles: In the base frame.
        """
        self._move(joints)
        best = MOST_MM / MM_PER_M
        for body in self._bodies(obstacles):
            points = pybullet.getClosestPoints(
                self._body, body, MOST_MM / MM_PER_M, physicsClientId=self._client
            )
            best = min([best, *(point[8] for point in points if point[3] in self._moving)])
            pybullet.removeBody(body, self._client)
        return float(best * MM_PER_M)

    def self_gap_mm(self, joints: Array) -> float:
        """Least distance of links that may not touch [mm], below 0 in overlap."""
        self._move(joints)
        best = SELF_MOST_MM / MM_PER_M
        for first, second in self._pairs:
            points = pybullet.getClosestPoints(
                self._body, self._body, best, first, second, physicsClientId=self._client
            )
            best = max(min([best, *(point[8] for point in points)]), -SELF_MOST_MM / MM_PER_M)
            if best <= -SELF_MOST_MM / MM_PER_M:
                break
        return float(best * MM_PER_M)

    def _move(self, joints: Array) -> None:
        for name, position in self._robot.positions(joints).items():
            pybullet.resetJointState(
                self._body, self._joints[name], position, physicsClientId=self._client
            )

    def _bodies(self, obstacles: Obstacles) -> list[int]:
        bodies = []
        for box in obstacles.boxes:
            half = [edge / 2.0 for edge in box.size]
            w, x, y, z = box.orientation
            bodies.append(
                self._solid((x, y, z, w), box.position, pybullet.GEOM_BOX, halfExtents=half)
            )
        for sphere in obstacles.spheres:
            straight = (0.0, 0.0, 0.0, 1.0)
            bodies.append(
                self._solid(straight, sphere.position, pybullet.GEOM_SPHERE, radius=sphere.radius)
            )
        return bodies

    def _solid(
        self, turn: Sequence[float], position: Sequence[float], kind: int, **size: Any
    ) -> int:
        client = self._client
        shape = pybullet.createCollisionShape(kind, physicsClientId=client, **size)
        place = pybullet.multiplyTransforms(*self._base, position, turn)
        body: int = pybullet.createMultiBody(0.0, shape, -1, *place, physicsClientId=client)
        pybullet.changeDynamics(body, -1, collisionMargin=0.0, physicsClientId=client)
        return body
