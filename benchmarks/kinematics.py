"""How fast the kinematic core is on this machine.

    python benchmarks/kinematics.py [robot ...]

The project is to be installed (`pip install -e .`). Prints, for each robot and on this machine:

- microseconds per pose of compiled forward kinematics, alone and with the Jacobian (one core,
  batches of 10,000, best of many), the same out of Pinocchio's C++ called pose by pose as the
  floor that a library sets, and their ratio (below 1: faster than the library);
- collision-free samples per second of one process that calls Pinocchio in a loop, of the dataset
  stage's sampler in one process and in as many as there are cores, and the ratio of last to first.

Limits stand in the heading; a figure that misses its limit is marked with `!`.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Callable

import numpy as np
import pinocchio

from pipeline.config import compose
from pipeline.data.chunk_executor import chunk_executor
from robots import Robot, available_robots, load_robot
from robots.kinematics import jacobians_kernel, poses_kernel
from robots.sampling import sample_configurations

BATCH = 10_000
REPEATS = 50
PINOCCHIO_SAMPLES = 2_000
SAMPLES = 300_000
# Limits: us per pose for Panda's seven joints, and gain over the loop on two cores.
POSE_LIMIT_US, JACOBIAN_LIMIT_US = 0.5, 1.0
GAIN_LIMIT = 1.8


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


def library(robot: Robot) -> tuple[float, float]:
    """Microseconds per pose out of Pinocchio: forward kinematics, and with the Jacobian.

    The call from Python is part of it, a fraction of a microsecond.
    """
    model, tip = robot.pinocchio()
    data = model.createData()
    joints = [np.array(q) for q in robot.sample(BATCH, collision_free=False)]
    if model.nq != robot.dof:
        joints = [pinocchio.integrate(model, pinocchio.neutral(model), q) for q in joints]

    def poses() -> None:
        for q in joints:
            pinocchio.framesForwardKinematics(model, data, q)

    def jacobians() -> None:
        for q in joints:
            pinocchio.computeFrameJacobian(model, data, q, tip, pinocchio.LOCAL_WORLD_ALIGNED)

    return 1e6 * best_of(poses, 5) / BATCH, 1e6 * best_of(jacobians, 5) / BATCH


def pinocchio_loop(robot: Robot) -> float:
    """Collision-free samples per second of one process that calls Pinocchio in a loop."""
    joints = robot.sample(PINOCCHIO_SAMPLES, collision_free=False)
    free = int((~robot.collision.exact.in_collision(joints)).sum())
    return free / best_of(lambda: robot.collision.exact.in_collision(joints), 3)


def dataset(robot: Robot, processes: int) -> float:
    """Collision-free samples per second, starting the processes included."""
    sample_configurations(robot, 1, seed=1)  # compiled code is read from disk once
    start = time.perf_counter()
    sample_configurations(
        robot, SAMPLES, seed=1, executor=chunk_executor(compose().engine, processes)
    )
    return SAMPLES / (time.perf_counter() - start)


def main(names: list[str]) -> None:
    cores = len(os.sched_getaffinity(0))
    robots = [load_robot(name) for name in names or available_robots()]
    print("us per pose, one core: ours / Pinocchio = ratio; limits (Panda): ", end="")
    print(f"FK {POSE_LIMIT_US}, FK with Jacobian {JACOBIAN_LIMIT_US}")
    for robot in robots:
        ours, theirs = kinematics(robot), library(robot)
        cells = [
            f"{name} {own:.3f}{' !' if own > limit else ''} / {other:.3f} = {own / other:.2f}"
            for name, own, other, limit in zip(
                ("FK", "FK+J"), ours, theirs, (POSE_LIMIT_US, JACOBIAN_LIMIT_US), strict=True
            )
        ]
        print(f"{robot.name:<10}{'   '.join(cells)}", flush=True)
    print(f"collision-free samples per second, {cores} cores; limit of the ratio: {GAIN_LIMIT}")
    for robot in robots:
        loop, alone, together = pinocchio_loop(robot), dataset(robot, 1), dataset(robot, cores)
        gain = together / loop
        print(
            f"{robot.name:<10}Pinocchio in a loop {loop:,.0f}, one process {alone:,.0f}, ", end=""
        )
        print(f"{cores} processes {together:,.0f}, ratio {gain:.1f}", end="")
        print(" !" if gain < GAIN_LIMIT else "", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
