"""Stage evaluate: solvers on the test poses of a robot, one raw row a pose."""

from __future__ import annotations

from pathlib import Path

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.data.dataset import read_split
from pipeline.data.tables import write_table
from pipeline.evaluation.runner import (
    Subject,
    clear_parts,
    count_poses,
    evaluate_solver,
    question,
)
from pipeline.progress import bar
from pipeline.settings import Config
from pipeline.solvers import check_solvers
from pipeline.stages.inputs import artifacts, dataset_of, robot_of, solver_of


def run(config: Config) -> list[Path]:
    """Write the raw rows of every solver of ``evaluate.solvers``, one Parquet file each."""
    robot = robot_of(config)
    check_solvers({"evaluate.solvers": config.evaluate.solvers}, robot)
    poses = read_split(dataset_of(config), "test", robot).poses
    poses = poses[: config.evaluate.poses or None]
    folders = artifacts(config)
    written = []
    for name in config.evaluate.solvers:
        subject = Subject(robot, solver_of(name, robot, config), poses, seed=config.seed)
        path = folders.evaluate(robot.name, name)
        parts = folders.root / "checkpoint" / f"evaluate-{robot.name}-{name}"
        with (
            exclusive(path),
            bar(
                count_poses(subject, config.evaluate), "pose", f"evaluate {robot.name} {name}"
            ) as shown,
        ):
            rows = evaluate_solver(subject, config.evaluate, parts, shown.update)
            asked = question(subject, config.evaluate)
            asked["profile"] = config.profile
            facts = {**provenance.made_by(), "commit": provenance.commit(), **asked}
            write_table(path, rows, facts)
            clear_parts(parts)
        written.append(path)
    return written
