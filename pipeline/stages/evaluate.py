"""Stage evaluate: solvers on the test poses of a robot, one raw row a pose."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import baselines
from baselines import Solver
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
    if config.evaluate.seeded_by != HOME:
        check_seeder("evaluate.seeded_by", config.evaluate.seeded_by, robot)


def run(config: Config) -> list[Path]:
    """Write the raw rows of every solver of ``evaluate.solvers``, one Parquet file each.

    On an engine every solver is a task of its own, on a core that no other one is timed on.
    """
    solvers = solvers_for("evaluate.solvers", config.evaluate.solvers, robot_of(config))
    config = replace(config, evaluate=replace(config.evaluate, solvers=solvers))
    if fans_out(config.engine):
        config = _sharing(config)
    tasks = [(config, name) for name in config.evaluate.solvers]
    return run_tasks(config.engine, _one, tasks, title="evaluate")


def _sharing(config: Config) -> Config:
    """Say how many evaluations share a machine."""
    beside = min(workers_of(config.engine), len(config.evaluate.solvers), usable_cores())
    beside = beside if one_machine(config.engine) else config.evaluate.side_by_side
    return replace(config, evaluate=replace(config.evaluate, side_by_side=beside))


def _one(job: tuple[Config, str]) -> Path:
    config, name = job
    robot = robot_of(config)
    poses = read_split(dataset_of(config), "test", robot).poses
    poses = poses[: config.evaluate.poses or None]
    solver, seeder = solver_of(name, robot, config), _seeder(robot, config)
    label = row_name(name, config.evaluate.pinned)
    code = code_of(__name__, {"solver": [name], "seeder": [seeder.name] if seeder else []}, config)
    task = EvaluationTask(robot, solver, poses, config.seed, label, seeder=seeder, code=code)
    if not fans_out(config.engine):
        return _evaluate(task, config)
    with own_cores(config.evaluate.threads if config.evaluate.pinned else usable_cores()) as first:
        return _evaluate(task, _on_core(config, first))


def _on_core(config: Config, first: int) -> Config:
    return replace(config, evaluate=replace(config.evaluate, first_core=first))


def _seeder(robot: Robot, config: Config) -> Solver | None:
    name = config.evaluate.seeded_by
    return None if name == HOME else solver_of(name, robot, config)


def _evaluate(task: EvaluationTask, config: Config) -> Path:
    robot, label = task.robot.name, task.label
    seeded_by = task.seeder.name if task.seeder is not None else ""
    folders = artifacts(config)
    path = folders.evaluate(robot, label, seeded_by)
    title = f"evaluate-{robot}-{label}" + (f"-{seeded_by}" if seeded_by else "")
    cache = folders.root / "checkpoint" / title
    key = {**cache_key(task, config.evaluate), "profile": config.profile}
    with exclusive(path):
        if config.evaluate.keep and is_up_to_date(path, key):
            LOGGER.info("%s holds these rows already", path)
            return path
        with bar(count_poses(task, config.evaluate), "pose", title.replace("-", " ")) as shown:
            rows = evaluate_solver(task, config.evaluate, cache, shown.update)
        facts = {**provenance.made_by(), **provenance.signature(config.profile), **key}
        facts |= {"weights": weights_origin(task.solver), "network": network_of(task.solver)}
        write_table(path, rows, facts)
        clear_chunks(cache)
    return path
