"""How often is a pose among obstacles reached free of collision, and what does it take?

    python -m benchmarks.cluttered [--robots panda nicol] [--poses 200] [--write]

The suite `cluttered` with so many poses: a configuration is known that keeps 50, 20, 10 or 5 mm
from boxes and spheres; half of that is requested. Compared on one core: solvers that are not given
them; *pick and filter*, the first free one of many answers of `lm` (`avoid_steps=0`); and `avoid=`
as it is. Every answer is judged by coal and by PyBullet. What it takes is counted in iterations,
those in the null space and of failures included.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import pandas as pd

from baselines import SkippedSolver
from benchmarks.studies import write_study
from pipeline import load_robot, load_solver
from pipeline.config import compose
from pipeline.evaluation.config import EvaluateConfig
from pipeline.evaluation.runner import evaluate_solver
from pipeline.evaluation.task import EvaluationTask
from pipeline.presentation.columns import Cell, number, under
from pipeline.presentation.naming import robot_title, solver_title
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.topics.suites import cluttered
from pipeline.suites.generators import Suite, generate
from pipeline.suites.rows import obstacles, with_problems
from robots import Robot

NAME = "cluttered"
# Name in the table, solver, its settings, and whether it is given the obstacles.
VARIANTS: tuple[tuple[str, str, dict[str, Any], bool], ...] = (
    ("trac_ik, obstacles not given", "trac_ik", {}, False),
    ("lm, obstacles not given", "lm", {}, False),
    ("lm, pick and filter", "lm", {"avoid_steps": 0}, True),
    ("lm, avoid", "lm", {}, True),
    ("cycleik_refined, avoid", "cycleik_refined", {}, True),
)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=["panda", "nicol"])
    parser.add_argument("--poses", type=int, default=200)
    parser.add_argument("--write", action="store_true", help="also into results/studies")
    return parser.parse_args()


def answers(
    robot: Robot, suite: Suite, variant: tuple[str, str, dict[str, Any], bool], how: EvaluateConfig
) -> pd.DataFrame:
    """Raw rows of one variant."""
    label, name, settings, given = variant
    sets = obstacles(suite.problems) if given else None
    solver = load_solver(name, robot, **settings)
    task = EvaluationTask(robot, solver, suite.problems.poses, 0, label, avoid=sets)
    return with_problems(evaluate_solver(task, how), suite, robot, given)


def table_of(rows: Mapping[tuple[str, str, str], pd.DataFrame], config: ReportConfig) -> Table:
    """All clearances together and each, iterations in the place of times."""
    whole = {key: part.assign(stratum="all") for key, part in rows.items()}
    lines: list[list[Cell]] = []
    for each in (whole, rows):
        taken = {
            (robot_title(robot), str(kind), solver_title(solver)): part.iterations
            for (robot, _, solver), among in each.items()
            for kind, part in among.groupby("stratum")
        }
        table = cluttered(each, config)
        kept = [k for k, column in enumerate(table.columns) if not column.name.startswith("time_")]
        for row in table.rows:
            iterations = taken[str(row[0]), str(row[1]), str(row[2])]
            cells: list[Cell] = [float(iterations.mean()), float(iterations.median())]
            lines.append([*(row[k] for k in kept), *cells])
    columns = [table.columns[k] for k in kept]
    columns += under("iterations", number("mean", "mean"), number("median", "median"))
    return replace(table, columns=columns, rows=lines)


def main() -> None:
    """Print the table."""
    options = arguments()
    config = compose([f"suite={NAME}", f"suite.poses={options.poses}"])
    how = replace(config.evaluate, batch_sizes=[1], error_batch_size={}, time_s=None)
    rows: dict[tuple[str, str, str], pd.DataFrame] = {}
    checksums = []
    for name in options.robots:
        robot = load_robot(name)
        suite = generate(robot, config.suite, config.seed)
        checksums.append(f"{name} {suite.checksum[:12]}")
        for variant in VARIANTS:
            try:
                rows[name, NAME, variant[0]] = answers(robot, suite, variant, how)
            except SkippedSolver as reason:
                print(reason)
    table = table_of(rows, config.report)
    text = table.to_markdown().partition("\n")[2]  # without the line on the report
    print(text)
    if options.write:
        chosen = f"--robots {' '.join(options.robots)} --poses {options.poses}"
        command = f"python -m benchmarks.cluttered {chosen} --write"
        seeds = f"of the suite {config.seed}; checksums {', '.join(checksums)}"
        write_study(NAME, pd.DataFrame(table.records()), text, command, seeds)


if __name__ == "__main__":
    main()
