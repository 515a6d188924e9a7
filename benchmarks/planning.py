"""How long does a plan of 50 poses take, and how many are free of branch flips?

    python benchmarks/planning.py [--robots panda ...] [--pairs 200] [--solver cycleik_refined]

Straight paths between random collision-free configurations, both ends given as poses. Median times
are those of plans whose path stays in reach, path, query, repair and any other curve included;
`busy` is the processor time of the planning thread, for machines that have other work to do.
Limits stand in the header: below 5 ms, at least 99 % without a flip, below 1 mm.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass

import numba
import numpy as np
import torch

import baselines
from baselines.lm_kernel import LmOptions
from pipeline import load_solver
from pipeline.config import compose
from pipeline.planning.benchmark import Pair, plan_pair, random_pairs
from pipeline.planning.config import PlanConfig
from pipeline.planning.continuity import fits, kernel_options
from pipeline.planning.motion import Motion
from pipeline.planning.reach import stays_in_reach
from robots import Robot, available_robots, load_robot

SEED = 29
WARM_UP = 3  # plans before the first that is timed


@dataclass(frozen=True)
class Plan:
    """One plan: wall and processor time, whether its path stays in reach, and what came of it."""

    wall_ms: float
    busy_ms: float
    in_reach: bool
    smooth: bool
    rerouted: bool
    tip_error_mm: float


def main() -> None:
    options = arguments()
    torch.set_num_threads(options.threads)
    numba.set_num_threads(options.threads)
    print(f"{options.solver}, {options.pairs} pairs a robot, {options.threads} thread(s)\n")
    print(
        "| robot | in reach | median ms (< 5) | busy median | p90 | busy, other curves "
        "| as requested % | with other curves % (>= 99) | largest tip error mm (< 1) "
        "| beyond reach, planned % |"
    )
    print(f"|{'---|' * 10}")
    for name in options.robots:
        print(line(name, plans_of(name, options)))


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument("--pairs", type=int, default=200)
    parser.add_argument("--solver", default="cycleik_refined")
    parser.add_argument("--threads", type=int, default=1)
    return parser.parse_args()


def plans_of(name: str, options: argparse.Namespace) -> list[Plan]:
    robot = load_robot(name)
    solver, repair = load_solver(options.solver, robot), baselines.load("lm", robot)
    config = compose([f"robot={name}"]).plan
    tolerances = kernel_options(repair)
    assert tolerances is not None
    pairs = random_pairs(robot, options.pairs, SEED)
    for pair in pairs[:WARM_UP]:
        plan_pair(robot, solver, pair, config, repair)
    return [timed(robot, solver, pair, config, repair, tolerances) for pair in pairs]


def timed(
    robot: Robot,
    solver: baselines.Solver,
    pair: Pair,
    config: PlanConfig,
    repair: baselines.Solver,
    tolerances: LmOptions,
) -> Plan:
    begin, busy = time.perf_counter(), time.thread_time()
    motion = plan_pair(robot, solver, pair, config, repair)
    wall_ms, busy_ms = 1e3 * (time.perf_counter() - begin), 1e3 * (time.thread_time() - busy)
    return Plan(
        wall_ms,
        busy_ms,
        in_reach(robot, motion, tolerances),
        fits(robot, motion.joints, motion.found, motion.poses),
        motion.route is not None,
        float(motion.tip_error_mm.max()),
    )


def in_reach(robot: Robot, motion: Motion, tolerances: LmOptions) -> bool:
    if motion.route is None and motion.found.all():
        return True
    return stays_in_reach(robot, motion.requested, tolerances)


def line(name: str, plans: list[Plan]) -> str:
    inside = [plan for plan in plans if plan.in_reach]
    beyond = [plan.smooth for plan in plans if not plan.in_reach]
    smooth = np.array([plan.smooth for plan in inside])
    other = np.array([plan.rerouted for plan in inside])
    wall = np.array([plan.wall_ms for plan in inside])
    busy = np.array([plan.busy_ms for plan in inside])
    cells = [
        name,
        f"{len(inside)}",
        f"{np.median(wall):.2f}",
        f"{np.median(busy):.2f}",
        f"{np.quantile(wall, 0.9):.1f}",
        f"{np.median(busy[other]):.1f}" if other.any() else "-",
        f"{100 * (smooth & ~other).mean():.1f}",
        f"{100 * smooth.mean():.1f}",
        f"{max(plan.tip_error_mm for plan in inside if plan.smooth):.3f}",
        f"{100 * np.mean(beyond):.1f}" if beyond else "-",
    ]
    return f"| {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
