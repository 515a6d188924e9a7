"""Stage sample: many solutions of one pose by a solver that draws, and a picture of them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.containers import to_dict
from pipeline.data.dataset import read_split
from pipeline.data.files import replacing
from pipeline.data.tables import write_table
from pipeline.evaluation.cache import solver_identity
from pipeline.evaluation.sampling import sample_rows, sampler_of
from pipeline.solvers import check_solvers, network_of, sampling_name
from pipeline.stages.inputs import artifacts, dataset_of, robot_of
from pipeline.stages.solvers import solver_of

if TYPE_CHECKING:
    from pipeline.settings import Config


def check(config: Config) -> None:
    """Refuse a run whose solver cannot run, before anything is made."""
    check_solvers(config.sample.solvers_by_key(), robot_of(config))


def run(config: Config) -> list[Path]:
    """Write raw rows, two a solution, and the robot in some solutions of one pose as PNG."""
    robot = robot_of(config)
    wanted = config.sample
    poses = read_split(dataset_of(config), "test", robot).poses[: wanted.poses]
    solver = solver_of(wanted.solver, robot, config)
    sampler_of(solver)
    path = artifacts(config).sample(robot.name, sampling_name(wanted.solver, config))
    with exclusive(path):
        rows = sample_rows(robot, solver, poses, wanted, config.evaluate.limit_slack)
        facts = {**provenance.made_by(), **provenance.signature(config.profile)}
        facts |= {"seed": config.seed, "network": network_of(solver)}
        facts |= {"sample": to_dict(wanted), "solver_identity": solver_identity(solver)}
        write_table(path, rows, facts)
        if not wanted.postures or robot.description.picture is None:
            return [path]
        from robots.picture import draw_overlay  # PyBullet takes a second to load

        shown = rows[rows.refined & (rows.pose == wanted.pictured)][: wanted.postures]
        joints = shown[[f"q{joint}" for joint in range(robot.dof)]].to_numpy(dtype=float)
        picture = path.with_suffix(".png")
        with replacing(picture) as partial:
            draw_overlay(robot, joints).save(partial, format="PNG", optimize=True)
    return [path, picture]
