"""Stage evaluate: solvers on the test poses of a robot, one raw row a pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

import baselines
from baselines import Solver
from baselines.registry import file_settings
from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.data.dataset import read_split
from pipeline.data.tables import write_table
from pipeline.engine.cores import own_cores, usable_cores
from pipeline.engine.running import fans_out, one_machine, run_tasks, workers_of
from pipeline.evaluation.cache import cache_key, clear_chunks, is_up_to_date
from pipeline.evaluation.config import HOME, row_name
from pipeline.evaluation.runner import count_poses, evaluate_solver
from pipeline.evaluation.task import EvaluationTask
from pipeline.progress import LOGGER, bar
from pipeline.solvers import check_budgets, check_seeder, network_of, solvers_for, weights_origin
from pipeline.stages.inputs import artifacts, dataset_of, robot_of
from pipeline.stages.solvers import code_of, solver_of
from robots import Robot

if TYPE_CHECKING:
    from pipeline.settings import Config

Job = tuple["Config", str]  # a run and the solver that is evaluated


def check(config: Config) -> None:
    """Refuse a run whose solvers or seeder cannot run, before anything is made."""
    robot = robot_of(config)
    for key, names in config.evaluate.solvers_by_key().items():
        able = solvers_for(key, names, robot)
        for name in names:
            if name not in able:
                why = baselines.skip(name, robot)
                LOGGER.warning("%s goes on without solver '%s': %s", key, name, why)
    check_budgets(config)
    for name in (*config.evaluate.time_factor, *config.evaluate.error_batch_size):
        file_settings(name)  # a solver that does not exist is a typo
    if config.evaluate.seeded_by != HOME:
        check_seeder("evaluate.seeded_by", config.evaluate.seeded_by, robot)


def run(config: Config) -> list[Path]:
    """Write the raw rows of every solver of ``evaluate.solvers``, one Parquet file each.

    On an engine every solver is a task of its own, on a core that no other one is timed on.
    """
    return each_solver(config, _one)


def each_solver(config: Config, one: Callable[[Job], Path]) -> list[Path]:
    """Run a function for each of ``evaluate.solvers`` on the engine of a run.

    Args:
        config: Of the run.
        one: Writes the rows of one solver, a function of a module that workers can import.
    """
    solvers = solvers_for("evaluate.solvers", config.evaluate.solvers, robot_of(config))
    config = replace(config, evaluate=replace(config.evaluate, solvers=solvers))
    if fans_out(config.engine):
        config = _sharing(config)
    tasks = [(config, name) for name in config.evaluate.solvers]
    return run_tasks(config.engine, one, tasks, title="evaluate")


def _sharing(config: Config) -> Config:
    """Say how many evaluations share a machine."""
    beside = min(workers_of(config.engine), len(config.evaluate.solvers), usable_cores())
    beside = beside if one_machine(config.engine) else config.evaluate.side_by_side
    return replace(config, evaluate=replace(config.evaluate, side_by_side=beside))


def _one(job: Job) -> Path:
    config, name = job
    robot = robot_of(config)
    poses = read_split(dataset_of(config), "test", robot).poses
    poses = poses[: config.evaluate.poses or None]
    solver, seeder = solver_of(name, robot, config), _seeder(robot, config)
    label = row_name(name, config.evaluate.pinned)
    code = code_of(__name__, {"solver": [name], "seeder": [seeder.name] if seeder else []}, config)
    task = EvaluationTask(robot, solver, poses, config.seed, label, seeder=seeder, code=code)
    seeded_by = seeder.name if seeder is not None else ""
    path = artifacts(config).evaluate(robot.name, label, seeded_by)
    title = f"evaluate-{robot.name}-{label}" + (f"-{seeded_by}" if seeded_by else "")
    return write_rows(task, config, path, title)


def _seeder(robot: Robot, config: Config) -> Solver | None:
    name = config.evaluate.seeded_by
    return None if name == HOME else solver_of(name, robot, config)


def write_rows(
    task: EvaluationTask,
    config: Config,
    path: Path,
    title: str,
    facts: Mapping[str, Any] | None = None,
    completed: Callable[[pd.DataFrame], pd.DataFrame] = lambda rows: rows,
) -> Path:
    """Evaluate a task, on a core of its own where the engine has several, and write its rows.

    Args:
        task: What is evaluated.
        config: Of the run.
        path: The table; a killed run continues from the chunks that it left.
        title: Of the bar and of the folder of those chunks.
        facts: Further facts that the rows depend on.
        completed: Adds columns to the rows before they are written.

    Returns:
        The path.
    """
    if not fans_out(config.engine):
        return _write(task, config, path, title, facts or {}, completed)
    with own_cores(config.evaluate.threads if config.evaluate.pinned else usable_cores()) as first:
        return _write(task, _on_core(config, first), path, title, facts or {}, completed)


def _on_core(config: Config, first: int) -> Config:
    return replace(config, evaluate=replace(config.evaluate, first_core=first))


def _write(
    task: EvaluationTask,
    config: Config,
    path: Path,
    title: str,
    further: Mapping[str, Any],
    completed: Callable[[pd.DataFrame], pd.DataFrame],
) -> Path:
    cache = artifacts(config).root / "checkpoint" / title
    key = {**cache_key(task, config.evaluate), **further, "profile": config.profile}
    with exclusive(path):
        if config.evaluate.keep and is_up_to_date(path, key):
            LOGGER.info("%s holds these rows already", path)
            return path
        with bar(count_poses(task, config.evaluate), "pose", title.replace("-", " ")) as shown:
            rows = evaluate_solver(task, config.evaluate, cache, shown.update)
        facts = {**provenance.made_by(), **provenance.signature(config.profile), **key}
        facts |= {"weights": weights_origin(task.solver), "network": network_of(task.solver)}
        write_table(path, completed(rows), facts)
        clear_chunks(cache)
    return path
