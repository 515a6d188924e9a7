"""Stage evaluate-suite: solvers on a suite of hard poses of a robot, one raw row a pose."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from pipeline.errors import ConfigError
from pipeline.evaluation.config import HOME, row_name
from pipeline.evaluation.task import EvaluationTask
from pipeline.stages import evaluate
from pipeline.stages.evaluate import Job, each_solver, write_rows
from pipeline.stages.inputs import artifacts, robot_of, suite_of
from pipeline.stages.solvers import code_of, solver_of
from pipeline.suites.part import first_trajectories
from pipeline.suites.problems import freedoms
from pipeline.suites.rows import follows, initial, obstacles, with_abilities, with_problems

if TYPE_CHECKING:
    from pipeline.settings import Config


def check(config: Config) -> None:
    """Refuse a run whose solvers cannot run, or whose starts are not those of the suite."""
    evaluate.check(config)
    if config.evaluate.seeded_by != HOME:
        raise ConfigError(
            f"evaluate.seeded_by={config.evaluate.seeded_by}: a suite says where solvers start; "
            "leave it at home, or use the stage evaluate"
        )


def run(config: Config) -> list[Path]:
    """Write the raw rows of every solver of ``evaluate.solvers``, judged as those of `evaluate`.

    Poses are handed over one by one, but to solvers of ``evaluate.error_batch_size``. A suite that
    has starts gives them to the solver. A suite with freedoms asks under them, but solvers of whole
    poses for those; all are judged under the freedoms. In unreachable solvers that explain a "no"
    are asked for the reason, untimed. In tracking ``evaluate.trajectories`` may say how many a
    solver answers, the first ones.
    """
    return each_solver(config, _one)


def _one(job: Job) -> Path:
    config, name = job
    robot = robot_of(config)
    suite = suite_of(config)
    if config.evaluate.trajectories:
        suite = first_trajectories(suite, config.evaluate.trajectories)
    batch_size = config.evaluate.error_batch_size.get(name, 1)
    config = replace(config, evaluate=replace(config.evaluate, batch_sizes=[batch_size]))
    label = row_name(name, config.evaluate.pinned)
    solver = solver_of(name, robot, config)
    task = EvaluationTask(
        robot,
        solver,
        suite.problems.poses,
        config.seed,
        label,
        initial=initial(suite.problems, robot),
        follows=follows(suite.problems),
        freedoms=freedoms(suite.problems),
        avoid=obstacles(suite.problems),
        code=code_of(__name__, {"solver": [name]}, config),
    )
    facts = {
        "suite": suite.name,
        "suite_version": suite.version,
        "suite_checksum": suite.checksum,
    }
    path = artifacts(config).evaluate_suite(robot.name, suite.name, label)
    title = f"evaluate_suite-{robot.name}-{suite.name}-{label}"

    def completed(rows: pd.DataFrame) -> pd.DataFrame:
        known = with_problems(rows, suite, robot, task.asks_to_avoid)
        return with_abilities(known, suite, solver)

    return write_rows(task, config, path, title, facts, completed)
