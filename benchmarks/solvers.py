"""How good and how fast the solvers are on this machine, pinned to one core.

    python benchmarks/solvers.py [--robots panda ...] [--solvers lm ...] [--time-s 0.001]
                                 [--iterations N] [--poses 1000] [--unreachable]

Prints a Markdown table with a row for each robot and solver: success at 1 mm / 1 deg (Euclidean,
geodesic) and by the paper's rule (10 mm / 20 deg, means over the axes), both recomputed from the
joints; claims that are wrong; rows outside the limits; microseconds and iterations per pose. With
`--unreachable` the poses are out of reach, and the table shows how the time budget is kept: the
bar is 20 % plus 0.2 ms at the 99th percentile.
"""

from __future__ import annotations

import argparse
import os

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import baselines
from baselines import Budget, BudgetError, SkippedSolver, Solution
from baselines.registry import settings
from robots import Robot, available_robots, load_robot

SEED = 1
WARM_UP = 5
FAR_M = 10.0
HEAD = (
    "| robot | solver | 1 mm/1 deg % | paper % | claimed % | wrong claims | out of limits "
    "| median us | mean us | p99 us | iterations |"
)


def arguments() -> argparse.Namespace:
    neural = {name for name in baselines.names() if "weights" in settings(name)}
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument(
        "--solvers", nargs="+", default=[n for n in baselines.names() if n not in neural]
    )
    parser.add_argument("--time-s", type=float)
    parser.add_argument("--iterations", type=int)
    parser.add_argument("--poses", type=int, default=1000)
    parser.add_argument("--unreachable", action="store_true")
    return parser.parse_args()


def budget_of(options: argparse.Namespace) -> Budget | None:
    if options.time_s is None and options.iterations is None:
        return None
    return Budget(options.time_s, options.iterations)


def errors(
    robot: Robot, joints: NDArray[np.float64], poses: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Success (N,) at 1 mm / 1 deg, and by the paper's means over axes of |x| and |zyx Euler|."""
    reached = robot.forward_kinematics(joints)
    delta = reached[:, :3] - poses[:, :3]
    turn = (
        Rotation.from_quat(poses[:, 3:], scalar_first=True)
        * Rotation.from_quat(reached[:, 3:], scalar_first=True).inv()
    )
    precise = (np.linalg.norm(delta, axis=1) < 1e-3) & (np.degrees(turn.magnitude()) < 1.0)
    euler = np.abs(turn.as_euler("zyx", degrees=True)).mean(axis=1)
    return precise, (np.abs(delta).mean(axis=1) < 1e-2) & (euler < 20.0)


def row(robot: Robot, name: str, solution: Solution, poses: NDArray[np.float64]) -> str:
    precise, paper = errors(robot, solution.joints, poses)
    joints = solution.joints
    outside = ((joints < robot.lower) | (joints > robot.upper)).any(axis=1).sum()
    time_us = 1e6 * solution.time_s
    cells = [
        robot.name,
        name,
        *(f"{100 * share.mean():.2f}" for share in (precise, paper, solution.found)),
        str(int((solution.found & ~precise).sum())),
        str(int(outside)),
        *(f"{v:.1f}" for v in (np.median(time_us), time_us.mean(), np.percentile(time_us, 99))),
        f"{solution.iterations.mean():.1f}",
    ]
    return f"| {' | '.join(cells)} |"


def main() -> None:
    options = arguments()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    print(HEAD)
    print("|---" * (HEAD.count("|") - 1) + "|")
    for robot_name in options.robots:
        robot = load_robot(robot_name)
        joints = robot.sample(options.poses, seed=SEED, collision_free=False)
        poses = robot.forward_kinematics(joints)
        if options.unreachable:
            poses[:, 0] += FAR_M
        for name in options.solvers:
            try:
                solver = baselines.load(name, robot)
                solver.solve(poses[:WARM_UP], budget=budget_of(options))
                solution = solver.solve(poses, budget=budget_of(options))
            except (SkippedSolver, BudgetError) as reason:
                print(f"| {robot_name} | {name} | {reason} |")
                continue
            print(row(robot, name, solution, poses), flush=True)


if __name__ == "__main__":
    main()
