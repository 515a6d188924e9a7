"""Stage evaluate: solvers on the test poses of a robot, one raw row a pose."""

from __future__ import annotations

from pathlib import Path

from baselines import Solver
from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.data.dataset import read_split
from pipeline.data.tables import write_table
from pipeline.evaluation.config import HOME
from pipeline.evaluation.naming import row_name
from pipeline.evaluation.runner import clear_parts, count_poses, evaluate_solver, question
from pipeline.evaluation.subject import Subject
from pipeline.evaluation.whole import is_whole
from pipeline.progress import LOGGER, bar
from pipeline.settings import Config
from pipeline.solvers import check_seeder, check_solvers
from pipeline.stages.inputs import artifacts, dataset_of, robot_of, solver_of
from robots import Robot


def run(config: Config) -> list[Path]:
    """Write the raw rows of every solver of ``evaluate.solvers``, one Parquet file each."""
    robot = robot_of(config)
    check_solvers({"evaluate.solvers": config.evaluate.solvers}, robot)
    seeder = _seeder(robot, config)
    poses = read_split(dataset_of(config), "test", robot).poses
    poses = poses[: config.evaluate.poses or None]
    written = []
    for name in config.evaluate.solvers:
        label = row_name(name, config.evaluate.pinned)
        solver = solver_of(name, robot, config)
        subject = Subject(robot, solver, poses, config.seed, label, seeder=seeder)
        written.append(_evaluate(subject, config))
    return written


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
