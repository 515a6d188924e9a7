"""Which poses of the suites have a solution at all, by closed form, and `lm`'s rate of those.

    python -m benchmarks.ground_truth [--robots panda ur5 iiwa] [--poses 200] [--write]

A suite knows of its poses by construction that they can be reached, or by a bound or a search that
they cannot. Analytical solvers solve the same poses: `eaik` and `ssik` have all
solutions of a UR5, so that their "no" is a proof; of a Panda and an iiwa, which have a joint to
spare, `frankik` and `ssik` try many of its angles. `lm` gets iterations and no clock, so that the
table does not depend on the machine. With --write it goes to results/studies.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import baselines
from baselines import Budget, Solver
from benchmarks import package_robots
from benchmarks.studies import write_study
from pipeline.config import compose
from pipeline.evaluation.statistics import wilson_interval
from pipeline.suites.generators import generate
from robots import Robot, load_robot

NAME = "ground_truth"
# Of each robot the closed-form solvers, their settings, and whether they have all solutions.
ORACLES: dict[str, list[tuple[str, dict[str, Any], bool]]] = {
    "panda": [("frankik", {"samples": [60, 720]}, False), ("ssik", {}, False)],
    "ur5": [("eaik", {}, True), ("ssik", {}, True)],
    "iiwa": [("ssik", {}, False)],
}
SUITES = ("uniform", "at_limits", "near_singular", "boundary", "warm", "unreachable")
BUDGET = Budget(iterations=5000)
Flags = NDArray[np.bool_]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--robots", nargs="+", default=list(ORACLES), choices=list(ORACLES))
    parser.add_argument("--poses", type=int, default=200)
    parser.add_argument("--write", action="store_true")
    options = parser.parse_args()
    rows: list[dict[str, Any]] = []
    checksums = []
    for name in options.robots:
        package_robots.ensure(name)
        robot = load_robot(name)
        for suite in SUITES:
            config = compose([f"robot={name}", f"suite={suite}", f"suite.poses={options.poses}"])
            made = generate(robot, config.suite, config.seed)
            checksums.append(f"{name} {suite} {made.checksum[:12]}")
            problems = made.problems
            rows += judged(robot, suite, problems.poses, problems.joints, problems.stratum)
            print(f"{name} {suite}", flush=True)
    table = pd.DataFrame(rows)
    text = report(table)
    print(text)
    if options.write:
        chosen = f"--robots {' '.join(options.robots)} --poses {options.poses}"
        command = f"python -m benchmarks.ground_truth {chosen} --write"
        write_study(NAME, table, text, command, f"of the suites 0; {', '.join(checksums)}")


def judged(
    robot: Robot,
    suite: str,
    poses: NDArray[np.float64],
    known: NDArray[np.float64],
    stratum: NDArray[np.str_],
) -> Iterator[dict[str, Any]]:
    """Yield a line for each oracle, and in `unreachable` for each kind of pose.

    Args:
        robot: The robot.
        suite: Its name.
        poses: (N, 7) targets.
        known: (N, dof) a configuration that solves each, NaN where none is known.
        stratum: (N,) kinds.
    """
    made_so = np.isfinite(known).all(axis=1)
    answered = baselines.load("lm", robot).solve(poses, budget=BUDGET)
    kinds = stratum if suite == "unreachable" else np.full(len(poses), "all")
    for name, settings, complete in ORACLES[robot.name]:
        if reason := baselines.skip(name, robot):
            print(f"{robot.name} goes on without {name}: {reason}")
            continue
        solvable = _solvable(baselines.load(name, robot, **settings), poses)
        for kind in dict.fromkeys(kinds):
            rows = kinds == kind
            has = (solvable | made_so)[rows]
            rate = wilson_interval(int(answered.found[rows][has].sum()), int(has.sum()), 0.95)
            yield {
                "robot": robot.name,
                "suite": suite,
                "kind": kind,
                "oracle": name,
                "complete": complete,
                "poses": int(rows.sum()),
                "by_construction": int(made_so[rows].sum()),
                "by_oracle": int(solvable[rows].sum()),
                "missed_by_oracle": int((made_so & ~solvable)[rows].sum()),
                "new_by_oracle": int((solvable & ~made_so)[rows].sum()),
                "lm_of_solvable": rate.estimate if has.any() else None,
                "lm_low": rate.low if has.any() else None,
                "lm_high": rate.high if has.any() else None,
                "lm_found_where_none": int((answered.found[rows] & ~has).sum()),
                "lm_proven_no": sum("proven" in answered.reason[k] for k in np.flatnonzero(rows)),
            }


def _solvable(oracle: Solver, poses: NDArray[np.float64]) -> Flags:
    return np.asarray(oracle.solve(poses).found)


def report(table: pd.DataFrame) -> str:
    """The study as Markdown."""
    lines = [
        "# Which poses have a solution at all",
        "",
        "By construction of the suite, and by closed-form solvers inside the joint limits; *all*:",
        "the solver has all solutions of the arm, so that its no is a proof. Rates of `lm` (5,000",
        "iterations, no clock) are of the poses that have a solution by either, with 95 % Wilson",
        "intervals; *proven*: noes that `lm` rests on a bound of the reach.",
        "",
        "| robot | suite | kind | oracle | poses | solvable by construction | by the oracle | "
        "missed by it | new by it | `lm` of the solvable [%] | `lm` claims, none exists | "
        "`lm` proven no |",
        "|---|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for row in table.itertuples():
        solver = f"{row.oracle} (all)" if row.complete else row.oracle
        rate = "–"
        if row.by_construction or row.by_oracle:
            rate = f"{row.lm_of_solvable:.1%} [{row.lm_low:.1%}, {row.lm_high:.1%}]"
        lines.append(
            f"| {row.robot} | {row.suite} | {str(row.kind).replace('_', ' ')} | {solver} | "
            f"{row.poses} | {row.by_construction} | {row.by_oracle} | {row.missed_by_oracle} | "
            f"{row.new_by_oracle} | {rate} | {row.lm_found_where_none} | {row.lm_proven_no} |"
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
