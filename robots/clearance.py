"""How far configurations of a robot stay from obstacles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from robots.clearance_kernel import Scene, measure, new_room, place
from robots.errors import ObstacleError
from robots.obstacles import ObstacleRows, Obstacles, each_obstacles, obstacle_rows
from robots.shapes import build_shapes

if TYPE_CHECKING:
    from robots.robot import Robot

Array = NDArray[np.float64]
# Clearances are kept but for this [m]: the same sums in another order differ in the last bits.
ROUNDING_M = 1e-9


class ClearanceChecker:
    """Distances of a robot's moving links from obstacles in its base frame.

    Of cylinders beside boxes and of meshes a lower bound of the distance is known: what counts as
    free is so, but not all that is free counts.

    Attributes:
        scene: The robot's shapes for compiled code.
        base: (4, 4) pose of the base in the root's frame [m].

    Raises:
        UrdfError: A collision shape cannot be used.
        ObstacleError: A joint of the chain moves the base.
    """

    def __init__(self, robot: Robot) -> None:
        checker, bodies = robot.collision, robot.bodies
        if bodies.frame[robot.base] >= 0:
            raise ObstacleError(f"the base '{robot.base}' of {robot.name} is moved by its joints")
        self._robot = robot
        self.base: Array = bodies.pose[robot.base]
        links = [name for name, link in robot.urdf.links.items() if link.collisions]
        moving = [name for name in links if bodies.frame[name] >= 0]
        boxes = checker.mesh_boxes(links)
        shapes = build_shapes(robot.urdf, bodies, checker.pairs, boxes, moving)
        self.scene = Scene(checker.tree, shapes, np.flatnonzero(shapes.link_frame >= 0))

    def rows(self, obstacles: Obstacles | Sequence[Obstacles], count: int) -> ObstacleRows:
        """Return obstacles of `count` configurations as arrays for compiled code."""
        return obstacle_rows(each_obstacles(obstacles, count), self.base)

    def centres(self, joints: ArrayLike) -> Array:
        """Centres of the shapes that move, (M, 3) in the base frame for one configuration [m]."""
        room = new_room(self.scene, 0)
        place(self.scene, self._robot.as_joints(joints)[0], room)
        moving = room.centres[self.scene.shapes.frame >= 0]
        return np.asarray((moving - self.base[:3, 3]) @ self.base[:3, :3])

    def distances(
        self, joints: ArrayLike, obstacles: Obstacles | Sequence[Obstacles], most: float = 1.0
    ) -> Array:
        """Distance of the nearest moving link from the nearest obstacle.

        Args:
            joints: (N, dof) or (dof,), rad or m.
            obstacles: In the base frame, one set for all or N.
            most: Distances beyond are returned as this [m].

        Returns:
            (N,) m, below 0 the depth of the overlap.
        """
        q = self._robot.as_joints(joints)
        found = np.full(len(q), most)
        if len(q):
            rows = self.rows(obstacles, len(q))
            room = new_room(self.scene, int(rows.number.max()))
            measure(self.scene, rows, q, float(most), room, found)
        return found

    def free(
        self, joints: ArrayLike, obstacles: Obstacles | Sequence[Obstacles]
    ) -> NDArray[np.bool_]:
        """Whether configurations are free of self-collision and keep clear of their obstacles.

        Args:
            joints: (N, dof) or (dof,), rad or m.
            obstacles: In the base frame, with the clearance; one set for all or N.

        Returns:
            (N,) flags.
        """
        q = self._robot.as_joints(joints)
        clearance = np.array([each.clearance_m for each in each_obstacles(obstacles, len(q))])
        most = float(clearance.max(initial=0.0)) + 1e-3
        clear = self.distances(q, obstacles, most) >= clearance - ROUNDING_M
        return np.asarray(clear & ~self._robot.in_collision(q))
