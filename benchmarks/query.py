"""How long one query takes from Python, and one step of a motion that is tracked at 1 kHz.

    python -m benchmarks.query [--robots panda ...] [--solvers lm ...] [--write]

Prints two Markdown tables. The first: microseconds of `solve_one` (median, 99th percentile), of
`solve` with one pose, and of the kernel alone, below which no call can be: what lies between is
Python. The second: targets of a motion of at most 1 rad/s (or 1 m/s for a joint that slides), one a
millisecond, each solved from the answer before it: microseconds a step, the share that is found,
and the largest step of a joint beside the largest that the motion itself takes.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines import SkippedSolver, Solver
from benchmarks.studies import write_study
from pipeline import load_robot, load_solver
from robots import Robot, available_robots

SEED = 1
WARM_UP = 50
RATE_HZ = 1000.0
FASTEST = 1.0  # rad/s or m/s
CYCLES_S = (2.0, 9.0)  # periods of the joints' sines
MAX_JUMP = 0.02  # rad or m, twenty times what a joint moves in a step
QUERIES = ("lm", "cycleik", "cycleik_refined", "pinocchio", "frankik", "ssik", "optik", "placo")
TITLES = {
    "query": (
        "One query from Python on one core: microseconds of `solve_one`, of `solve` with one\n"
        "pose, and of the kernel alone; uniform poses."
    ),
    "tracking": (
        "A motion of at most 1 rad/s whose targets come at 1 kHz, each solved from the answer\n"
        "before it, on one core: microseconds a step, and the largest step of a joint [rad or m]."
    ),
}
TRACKED: tuple[tuple[str, dict[str, Any]], ...] = (
    ("lm", {}),
    ("lm", {"max_jump": MAX_JUMP}),
    ("cycleik_refined", {}),
    ("pinocchio", {"time_s": 1e-3}),
)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument("--solvers", nargs="+", default=QUERIES)
    parser.add_argument("--poses", type=int, default=2000)
    parser.add_argument("--write", action="store_true", help="also into results/studies")
    return parser.parse_args()


def timed(function: Callable[[Any], Any], values: Iterable[Any]) -> NDArray[np.float64]:
    """Microseconds of a call for each value."""
    spent = []
    for value in values:
        start = time.perf_counter_ns()
        function(value)
        spent.append(time.perf_counter_ns() - start)
    return np.array(spent) / 1e3


def query_row(robot: Robot, name: str, poses: NDArray[np.float64]) -> list[str]:
    """Cells of one solver: single queries."""
    solver = load_solver(name, robot)
    for pose in poses[:WARM_UP]:
        solver.solve_one(pose)
        solver.solve(pose[None])
    one = timed(solver.solve_one, poses)
    array = timed(lambda pose: solver.solve(pose[None]), poses)
    alone = [1e6 * solver.solve(pose[None]).time_s[0] for pose in poses]
    found = np.mean([solver.solve_one(pose)[1] for pose in poses])
    figures = np.median(one), np.percentile(one, 99), np.median(array), np.median(alone)
    return [*(f"{figure:.1f}" for figure in figures), f"{100 * found:.2f}"]


def motion(robot: Robot, count: int) -> NDArray[np.float64]:
    """Joints (count, dof) of a smooth motion inside the limits: a sine for each joint."""
    rng = np.random.default_rng(SEED)
    middle, half = (robot.lower + robot.upper) / 2, (robot.upper - robot.lower) / 2
    speeds = 2 * np.pi / rng.uniform(*CYCLES_S, robot.dof)
    swing = np.minimum(0.9 * half, FASTEST / speeds)
    phases = rng.uniform(0, 2 * np.pi, robot.dof)
    seconds = np.arange(count)[:, None] / RATE_HZ
    return np.asarray(middle + swing * np.sin(speeds * seconds + phases))


def tracking_row(robot: Robot, solver: Solver, joints: NDArray[np.float64]) -> list[str]:
    """Cells of one solver: a motion, each step from the answer before."""
    poses = robot.forward_kinematics(joints)
    solver.solve_one(poses[0], joints[0])
    current, steps, spent, found = joints[0], [], [], 0
    for pose in poses[1:]:
        start = time.perf_counter_ns()
        answer, good = solver.solve_one(pose, current)
        spent.append((time.perf_counter_ns() - start) / 1e3)
        found += good
        steps.append(np.abs(answer - current).max())
        current = answer
    own = np.abs(np.diff(joints, axis=0)).max()
    share = 100 * found / (len(poses) - 1)
    figures = np.median(spent), np.percentile(spent, 99), np.max(spent)
    cells = [*(f"{figure:.1f}" for figure in figures), f"{share:.2f}"]
    return [*cells, f"{max(steps):.4f}", f"{own:.4f}"]


def table(head: Iterable[str], rows: Iterable[list[str]]) -> pd.DataFrame:
    """Print a Markdown table, each row as soon as it is there, and return it."""
    titles, kept = list(head), []
    print(f"| {' | '.join(titles)} |\n{'|---' * len(titles)}|", flush=True)
    for row in rows:
        print(f"| {' | '.join(row)} |", flush=True)
        kept.append(row)
    print()
    return pd.DataFrame(kept, columns=titles)


def write(name: str, rows: pd.DataFrame, options: argparse.Namespace) -> None:
    """Put a table into results/studies."""
    command = f"python -m benchmarks.query --solvers {' '.join(options.solvers)} --write"
    write_study(name, rows, f"{TITLES[name]}\n\n{markdown(rows)}", command, str(SEED))


def markdown(rows: pd.DataFrame) -> str:
    """Cells as they were printed."""
    lines = [list(rows.columns), ["---"] * len(rows.columns), *rows.to_numpy().tolist()]
    return "\n".join(f"| {' | '.join(map(str, line))} |" for line in lines)


def main() -> None:
    """Print both tables."""
    options = arguments()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    robots = [load_robot(name) for name in options.robots]

    def queries() -> Iterable[list[str]]:
        for robot in robots:
            drawn = robot.sample(options.poses, seed=SEED, collision_free=False)
            poses = robot.forward_kinematics(drawn)
            for name in options.solvers:
                try:
                    yield [robot.name, name, *query_row(robot, name, poses)]
                except SkippedSolver:
                    continue

    def tracked() -> Iterable[list[str]]:
        for robot in robots:
            joints = motion(robot, options.poses)
            for name, settings in TRACKED:
                if name not in options.solvers:
                    continue
                try:
                    solver = load_solver(name, robot, **settings)
                except SkippedSolver:
                    continue
                label = ", ".join(f"{key}={value:g}" for key, value in settings.items())
                cells = tracking_row(robot, solver, joints)
                yield [robot.name, f"{name} ({label})" if label else name, *cells]

    one = table(
        ("robot", "solver", "one us", "p99 us", "array of one us", "kernel us", "found %"),
        queries(),
    )
    columns = ("step us", "p99 us", "max us", "found %", "largest step", "of the motion")
    steps = table(("robot", "solver", *columns), tracked())
    if options.write:
        write("query", one, options)
        write("tracking", steps, options)


if __name__ == "__main__":
    main()
