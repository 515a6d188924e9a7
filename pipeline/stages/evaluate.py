"""Stage evaluate: solvers on the test poses of a robot, one raw row a pose."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from baselines import Solver
from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.data.dataset import read_split
from pipeline.data.tables import write_table
from pipeline.engine.cores import own_cores, usable_cores
from pipeline.engine.running import fans_out, one_machine, run_tasks, workers_of
from pipeline.evaluation.config import HOME
from pipeline.evaluation.naming import row_name
from pipeline.evaluation.runner import clear_parts, count_poses, evaluate_solver, question
from pipeline.evaluation.subject import Subject
from pipeline.evaluation.whole import is_whole
from pipeline.progress import LOGGER, bar
from pipeline.settings import Config
from pipeline.solvers import check_seeder, check_solvers, is_neural
from pipeline.stages.inputs import artifacts, dataset_of, robot_of, solver_of
from robots import Robot


def run(config: Config) -> list[Path]:
    """Write the raw rows of every solver of ``evaluate.solvers``, one Parquet file each.

    On an engine every solver is a task of its own, on a core that no other one is timed on.
    """
    robot = robot_of(config)
    check_solvers({"evaluate.solvers": config.evaluate.solvers}, robot)
    if fans_out(config.engine):
        config = _apart(robot, config)
    tasks = [(config, name) for name in config.evaluate.solvers]
    return run_tasks(config.engine, _one, tasks, title="evaluate")


def _apart(robot: Robot, config: Config) -> Config:
    """Make here what several tasks would make at once, and say how many share a machine."""
    dataset_of(config)
    _seeder(robot, config)
    for name in config.evaluate.solvers:
        if is_neural(name):
            solver_of(name, robot, config)
    beside = min(workers_of(config.engine), len(config.evaluate.solvers), usable_cores())
    beside = beside if one_machine(config.engine) else config.evaluate.side_by_side
    return replace(config, evaluate=replace(config.evaluate, side_by_side=beside))


def _one(task: tuple[Config, str]) -> Path:
    config, name = task
    robot = robot_of(config)
    poses = read_split(dataset_of(config), "test", robot).poses
    poses = poses[: config.evaluate.poses or None]
    solver, seeder = solver_of(name, robot, config), _seeder(robot, config)
    label = row_name(name, config.evaluate.pinned)
    subject = Subject(robot, solver, poses, config.seed, label, seeder=seeder)
    if not fans_out(config.engine):
        return _evaluate(subject, config)
    with own_cores(config.evaluate.threads if config.evaluate.pinned else usable_cores()) as first:
        return _evaluate(subject, _on_core(config, first))


def _on_core(config: Config, first: int) -> Config:
    return replace(config, evaluate=replace(config.evaluate, first_core=first))


def _seeder(robot: Robot, config: Config) -> Solver | None:
    name = config.evaluate.seeded_by
    if name == HOME:
        return None
    check_seeder("evaluate.seeded_by", name, robot)
    return solver_of(name, robot, config)


def _evaluate(subject: Subject, config: Config) -> Path:
    robot, label = subject.robot.name, subject.label
    seeded_by = subject.seeder.name if subject.seeder is not None else ""
    folders = artifacts(config)
    path = folders.evaluate(robot, label, seeded_by)
    told = f"evaluate-{robot}-{label}" + (f"-{seeded_by}" if seeded_by else "")
    parts = folders.root / "checkpoint" / told
    asked = {**question(subject, config.evaluate), "profile": config.profile}
    with exclusive(path):
        if config.evaluate.keep and is_whole(path, asked):
            LOGGER.info("%s holds these rows already", path)
            return path
        with bar(count_poses(subject, config.evaluate), "pose", told.replace("-", " ")) as shown:
            rows = evaluate_solver(subject, config.evaluate, parts, shown.update)
        facts = {**provenance.made_by(), "commit": provenance.commit(), **asked}
        write_table(path, rows, facts)
        clear_parts(parts)
    return path
