"""How fast the kinematic core is on this machine.

    python benchmarks/kinematics.py [robot ...]

Prints, for each robot, microseconds per pose of compiled forward kinematics and Jacobians (one
core, batches of 10,000, best of many), and collision-checked samples per second beside one process
that calls Pinocchio in a loop.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable

import numpy as np

from robots import Robot, available_robots, load_robot
from robots.kinematics import jacobians_kernel, poses_kernel
from robots.sampling import sample_configurations

BATCH = 10_000
REPEATS = 50
PINOCCHIO_SAMPLES = 2_000
SAMPLES = 300_000


def best_of(call: Callable[[], object], repeats: int) -> float:
    """Seconds of the fastest call, which other processes disturbed least."""
    call()
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


def kinematics(robot: Robot) -> tuple[float, float]:
    """Microseconds per pose: forward kinematics, and with the Jacobian."""
    joints = robot.sample(BATCH, collision_free=False)
    poses, jacobians = np.empty((BATCH, 7)), np.empty((BATCH, 6, robot.dof))
    pose = best_of(lambda: poses_kernel(robot.chain, joints, poses), REPEATS)
    both = best_of(lambda: jacobians_kernel(robot.chain, joints, poses, jacobians), REPEATS)
    return 1e6 * pose / BATCH, 1e6 * both / BATCH


def pinocchio_loop(robot: Robot) -> float:
    """Collision-free samples per second of one process that calls Pinocchio in a loop."""
    joints = robot.sample(PINOCCHIO_SAMPLES, collision_free=False)
    free = int((~robot.collision.exact.in_collision(joints)).sum())
    return free / best_of(lambda: robot.collision.exact.in_collision(joints), 3)


def dataset(robot: Robot, processes: int) -> float:
    """Collision-free samples per second, starting the processes included."""
    start = time.perf_counter()
    sample_configurations(robot, SAMPLES, seed=1, processes=processes)
    return SAMPLES / (time.perf_counter() - start)


def main(names: list[str]) -> None:
    cores = len(os.sched_getaffinity(0))
    print(f"{cores} cores; us per pose, and collision-free samples per second")
    print(f"{'robot':<10}{'FK':>8}{'FK+J':>8}{'Pinocchio':>12}{'1 process':>12}", end="")
    print(f"{f'{cores} processes':>14}{'ratio':>8}")
    for robot in map(load_robot, names or available_robots()):
        pose, both = kinematics(robot)
        loop, alone, together = pinocchio_loop(robot), dataset(robot, 1), dataset(robot, cores)
        print(f"{robot.name:<10}{pose:>8.3f}{both:>8.3f}{loop:>12,.0f}{alone:>12,.0f}", end="")
        print(f"{together:>14,.0f}{together / loop:>8.1f}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
