"""Answers that are free of self-collision and obstacles: poses, seeds and obstacles in, joints out.

A batch runs on one thread. What comes back is checked again: joints that an exact library finds in
collision with the robot itself, as it may where shapes are meshes, are taken back, and the search
goes on with the next start.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from baselines.avoid_kernel import Slide, avoid_rows, new_work
from baselines.lm_kernel import FOUND, IN_COLLISION, LmOptions
from baselines.refine import Refined
from baselines.seed_library import SeedLibrary
from robots.clearance_kernel import new_room
from robots.obstacles import Obstacles

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

ROUNDS = 20  # times that answers are taken back and searched on


def refine_avoiding(
    robot: Robot,
    poses: Array,
    seeds: Array,
    options: LmOptions,
    slide: Slide,
    library: SeedLibrary,
    obstacles: Sequence[Obstacles],
) -> Refined:
    """Descend from each pose's seeds, then from random configurations, until solved and free.

    Args:
        robot: The robot.
        poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz.
        seeds: (N, K, dof) configurations to start from, inside the limits; K may be 0.
        options: Tolerances, damping and budget; the budget counts for each round.
        slide: How colliding configurations are moved.
        library: Configurations to start from after the seeds, the nearest first.
        obstacles: N sets in the base frame.

    Returns:
        As of `baselines.refine`; where nothing free was met, what reaches the pose and collides
        least.
    """
    result = Refined.empty(len(poses), robot.dof)
    time_ns = np.zeros(len(poses))
    waiting = np.arange(len(poses))
    scene, most = robot.clearance.scene, max(map(len, obstacles))
    work = new_work(len(robot.chain.prismatic), robot.dof, len(library.joints))
    room = new_room(scene, most)
    for _ in range(ROUNDS):
        sets = [obstacles[int(row)] for row in waiting]
        joints = np.empty((len(waiting), robot.dof))
        outcomes = np.empty((len(waiting), 4), dtype=np.int64)
        bound = scene, robot.clearance.rows(sets, len(sets)), slide, work, room
        first = result.starts[waiting]
        inputs = np.ascontiguousarray(poses[waiting]), np.ascontiguousarray(seeds[waiting])
        avoid_rows(robot.chain, *inputs, library, options, *bound, first, joints, outcomes)
        joints = robot.nearest_turns(joints)
        refuted = (outcomes[:, 0] == FOUND) & ~robot.clearance.free(joints, sets)
        status = np.where(refuted, IN_COLLISION, outcomes[:, 0])
        # What an earlier round has taken back reaches its pose at least.
        taken = np.isin(status, (FOUND, IN_COLLISION)) | (result.status[waiting] != IN_COLLISION)
        result.joints[waiting[taken]] = joints[taken]
        result.status[waiting[taken]] = status[taken]
        result.iterations[waiting] += outcomes[:, 1]
        result.starts[waiting] = outcomes[:, 2]
        time_ns[waiting] += outcomes[:, 3]
        waiting = waiting[refuted]
        if len(waiting) == 0:
            break
    np.multiply(time_ns, 1e-9, out=result.time_s)
    return result
