"""What a run of grasps is made of: units that need no other, and what their rows depend on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline import provenance
from pipeline.containers import to_dict
from pipeline.data.rows import RowCheckpoint
from pipeline.embodiment.loading import (
    embodied_facts,
    is_embodied,
    load_agent_series,
    perception_identity,
    setting_name,
)
from pipeline.embodiment.series import AgentSeries
from pipeline.engine.running import fans_out, run_tasks
from pipeline.evaluation.cache import solver_identity
from pipeline.grasping.ablation import Study
from pipeline.grasping.config import PINNED
from pipeline.grasping.placements import pinned_version
from pipeline.grasping.series import Series
from pipeline.progress import bar
from pipeline.provenance import digest
from pipeline.solvers import network_of
from pipeline.stages.eyes import detector_of
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.stages.solvers import code_of, solver_of

if TYPE_CHECKING:
    from pipeline.settings import Config
    from robots import Robot

Runner = Series | AgentSeries | Study
Unit = Any  # number of a trial, number of a row of objects, or variant and number
_loaded: dict[str, Runner] = {}  # what this worker ran last: loading takes longer than a trial


def load_runner(config: Config) -> Runner:
    """Load robot and solvers, with perception and agent where requested, of trials or of a study.

    Args:
        config: Of the run; its scene and solvers are checked already.
    """
    robot = robot_of(config)
    repair = solver_of(config.grasp.repair, robot, config) if config.grasp.repair else None
    solver = solver_of(config.grasp.solver, robot, config)
    series = Series(config.grasp, robot, solver, repair, config.seed)
    if config.grasp.ablation is not None:
        return Study(series, lambda name: solver_of(name, robot, config))
    if not is_embodied(config):
        return series
    folder = artifacts(config).grasp_agent(robot.name, setting_name(config))
    sees = config.perception.source == "camera"
    detector = detector_of(robot, config) if sees else None
    return load_agent_series(config, series, folder, detector)


@dataclass(frozen=True)
class RowIdentity:
    """What the rows of a run depend on, but not how many trials there are.

    Attributes:
        robot: The robot.
        facts: Settings.
        network: Name of the networks that solve, for people.
        path: File that keeps the rows while they are made; another name where anything differs.
    """

    robot: Robot
    facts: dict[str, Any]
    network: str
    path: Path


def row_identity(config: Config, runner: Runner) -> RowIdentity:
    """Say what the rows of a run depend on.

    Args:
        config: Of the run.
        runner: As `load_runner` gives it.
    """
    facts: dict[str, Any] = {
        "grasp": {**to_dict(config.grasp), "trials": None},
        "seed": config.seed,
    }
    if isinstance(runner, AgentSeries):
        kind, series = f"grasp-{setting_name(config)}", runner.experiment.series
        facts |= embodied_facts(config)
        eyes = perception_identity(runner)
    else:
        kind, eyes = ("study" if isinstance(runner, Study) else "grasp"), None
        series = runner.series if isinstance(runner, Study) else runner
    robot = series.robot
    if config.grasp.placements == PINNED:
        facts["placements"] = pinned_version(robot.name)
    solvers = [each for each in (series.solver, series.repair) if each is not None]
    who = [solver_identity(each) for each in solvers]
    code = code_of(__name__, config.grasp.solvers_by_key(), config)
    made_with = [facts, robot.urdf_checksum, who, eyes, provenance.versions(), code]
    name = f"{kind}-{robot.name}-{digest(made_with)}.jsonl"
    network = ", ".join(filter(None, map(network_of, solvers)))
    return RowIdentity(robot, facts, network, artifacts(config).root / "checkpoint" / name)


def run_units(config: Config, runner: Runner, kept: RowCheckpoint) -> None:
    """Run what is not yet kept on the engine, and keep each unit's rows as it ends.

    With a single worker on this machine nothing is done: the runner itself goes on from what is
    kept. So it does when a window shows the trials.

    Args:
        config: Of the run; a worker loads robot and solvers from it.
        runner: Says which units are missing.
        kept: Receives the rows.

    Raises:
        EngineError: Workers died; the rows of the others are kept.
    """
    if not fans_out(config.engine) or config.grasp.gui:
        return
    units = runner.pending(kept)
    with bar(len(units), "unit", f"grasp {config.robot.name} on {config.engine.name}") as shown:

        def keep(_: int, rows: list[dict[str, Any]]) -> None:
            for row in rows:
                kept.put(row)
            shown.update()

        run_tasks(config.engine, _unit, [(config, unit) for unit in units], keep, "grasp")


def _unit(task: tuple[Config, Unit]) -> list[dict[str, Any]]:
    config, unit = task
    key = digest(to_dict(config))
    if key not in _loaded:
        _loaded.clear()
        _loaded[key] = load_runner(config)
    return _loaded[key].unit(unit)
