"""`lm` and refined CycleIK on processor cores, beside cuRobo's and PyRoki's published batches.

    python -m benchmarks.published_batches [--threads 1 2] [--sizes 1 10 100 1000 2000] [--write]

Their protocol: B Panda poses of collision-free samples in one call; a pose is solved within 5 mm
and 0.05 rad; the time is that of the third, warm call, poses and answers on the host; the error is
the 98th percentile of the successes. Each solver runs twice: with that success as its tolerance,
and with 1e-4 mm. The other rows are published figures (benchmarks/published_batches.csv, with
sources) of other machines: they tell an order of magnitude, not a ranking.
`--write` keeps the table as results/studies/published_batches.{csv,md}.
"""

from __future__ import annotations

import argparse
import math
import shlex
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines import Solution, Solver
from benchmarks.accelerator_solvers.measure import accuracy, timed
from benchmarks.accelerator_solvers.rows import processor
from benchmarks.accelerator_solvers.solvers import options_of
from benchmarks.studies import write_study
from pipeline import load_solver
from robots import Robot, load_robot

Array = NDArray[np.float64]

PUBLISHED = Path(__file__).with_suffix(".csv")
SOLVERS = ("lm", "cycleik_refined")
TOLERANCES = ((5e-3, 0.05), (1e-7, 1e-7))  # m, rad: what their protocol counts, and 1e-4 mm
SEED = 11
COLUMNS = {
    "solver": "Solver",
    "batch": "B",
    "tolerance_mm": "tolerance [mm]",
    "call_ms": "call [ms]",
    "us_a_pose": "a pose [us]",
    "success": "success [%]",
    "p98_mm": "98th percentile [mm]",
    "hardware": "hardware",
    "source": "source",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robot", default="panda")
    parser.add_argument("--threads", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--sizes", nargs="+", type=int, default=[1, 10, 100, 1000, 2000])
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    robot = load_robot(options.robot)
    free = robot.sample(max(options.sizes), seed=SEED, collision_free=True)
    poses = robot.forward_kinematics(free)
    rows = [
        measured(robot, solver, poses[:size], threads, tolerance)
        for threads in options.threads
        for name in SOLVERS
        for solver, tolerance in zip(made(name, robot, threads), TOLERANCES, strict=True)
        for size in options.sizes
    ]
    table = pd.concat([pd.DataFrame(rows), pd.read_csv(PUBLISHED)], ignore_index=True)
    text = table[list(COLUMNS)].rename(columns=COLUMNS).to_markdown(index=False, floatfmt=".4g")
    print(text)
    if options.write:
        command = shlex.join(["python", "-m", "benchmarks.published_batches", *sys.argv[1:]])
        write_study("published_batches", table, text, command, str(SEED))


def made(name: str, robot: Robot, threads: int) -> list[Solver]:
    """A solver at each of the tolerances, in the order of `TOLERANCES`."""
    return [
        load_solver(name, robot, threads=threads, **in_its_units(name, position, rotation))
        for position, rotation in TOLERANCES
    ]


def in_its_units(name: str, position: float, rotation: float) -> dict[str, Any]:
    """Settings of a solver for a tolerance in m and rad."""
    if name == "lm":
        return {"position_tolerance_m": position, "rotation_tolerance_rad": rotation}
    return {
        "position_tolerance_mm": 1e3 * position,
        "rotation_tolerance_deg": math.degrees(rotation),
    }


def measured(
    robot: Robot, solver: Solver, poses: Array, threads: int, tolerance: tuple[float, float]
) -> dict[str, Any]:
    """One row: the third call's time, and the errors of its answers."""
    answers: list[Solution] = []
    third_ms, _ = timed(lambda: answers.append(solver.solve(poses)))
    judged = accuracy(robot, answers[2], poses, options_of(robot, *tolerance))
    return {
        "solver": solver.name,
        "batch": len(poses),
        "tolerance_mm": 1e3 * judged["tolerance_m"],
        "call_ms": third_ms,
        "us_a_pose": 1e3 * third_ms / len(poses),
        "success": judged["success_5mm_0.05rad"],
        "p98_mm": judged["p98_mm"],
        "hardware": f"{processor()}, {threads} core{'s' * (threads > 1)}",
        "source": "measured",
    }


if __name__ == "__main__":
    main()
