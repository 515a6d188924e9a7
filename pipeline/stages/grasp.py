"""Stage grasp: pick-and-drop trials in simulation, held by contact and friction alone.

With `perception=camera` or an `agent` the trials are those of the paper's human in the loop: all
objects on a row, one instruction a row, five classes.
"""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.data.files import write_json, write_sealed_json
from pipeline.data.rows import RowCheckpoint
from pipeline.data.tables import write_table
from pipeline.embodiment.loading import EVIDENCE, is_embodied, setting_name
from pipeline.embodiment.series import AgentSeries
from pipeline.errors import ConfigError, PerceptionError
from pipeline.grasping import ablation
from pipeline.grasping.ablation import Study
from pipeline.grasping.config import PINNED
from pipeline.grasping.outcome import SUCCESS
from pipeline.grasping.placements import check_pinned
from pipeline.grasping.series import KEY, Series
from pipeline.grasping.trial import required_scene
from pipeline.perception.camera import mounted
from pipeline.progress import bar
from pipeline.solvers import check_solvers
from pipeline.stages.grasp_units import load_runner, row_identity, run_units
from pipeline.stages.inputs import artifacts, robot_of
from robots import Robot

if TYPE_CHECKING:
    from pipeline.settings import Config


def check(config: Config) -> None:
    """Refuse a robot without a scene and solvers that cannot run, before anything is made."""
    robot = robot_of(config)
    scene = required_scene(config.grasp, robot.name)
    if config.grasp.placements == PINNED:
        check_pinned(robot.name, scene.objects, config.grasp.trials)
    check_solvers(config.grasp.solvers_by_key(), robot)
    if config.perception.source == "camera":
        _check_camera(robot)
    if config.speech.loop.voices and config.agent.kind == "none":
        raise ConfigError(
            "speech.loop.voices speak to an agent, and there is none: choose agent=policy"
        )
    if config.grasp.ablation is not None and is_embodied(config):
        raise ConfigError("a study of grasps needs perception=perfect and agent=none")


def _check_camera(robot: Robot) -> None:
    try:
        mounted(robot)
    except PerceptionError as error:
        raise PerceptionError(f"{error}; without one: perception=perfect agent=none") from error


def run(config: Config) -> list[Path]:
    """Write raw rows, films and the class counts of a robot's trials, or the rows of a study."""
    runner = load_runner(config)
    if isinstance(runner, Study):
        return _study(config, runner)
    if isinstance(runner, AgentSeries):
        folder = artifacts(config).grasp_agent(config.robot.name, setting_name(config))
    else:
        folder = artifacts(config).grasp(config.robot.name)
    return _trials(config, runner, folder)


def _trials(config: Config, runner: Series | AgentSeries, folder: Path) -> list[Path]:
    made = row_identity(config, runner)
    robot, facts = made.robot, made.facts
    with exclusive(folder):
        if not made.path.exists():  # nothing to go on with: what lies here is of an earlier run
            shutil.rmtree(folder / EVIDENCE, ignore_errors=True)
        kept = RowCheckpoint(made.path, KEY)
        run_units(config, runner, kept)
        with _Progress(config.grasp.trials, f"grasp {robot.name}") as progress:
            rows = runner.run(kept, progress)
        folder.mkdir(parents=True, exist_ok=True)
        runner.film(rows, folder)
        card = _card(config, robot)
        signed = {**provenance.signature(config.profile), "network": made.network}
        write_table(folder / "trials.parquet", rows, {**card, **facts, **signed})
        counts = {str(name): int(count) for name, count in rows["class"].value_counts().items()}
        write_json(folder / "metrics.json", counts)
        write_sealed_json(folder / "card.json", {**card, "config": {**card["config"], **facts}})
        kept.clear()
    return [folder]


def _study(config: Config, study: Study) -> list[Path]:
    series = study.series
    assert series.config.ablation is not None
    folder = artifacts(config).grasp_study(series.robot.name)
    made = row_identity(config, study)
    name = series.config.ablation.study
    with exclusive(folder):
        kept = RowCheckpoint(made.path, ablation.KEY)
        run_units(config, study, kept)
        with _Progress(study.trials, f"{name} {series.robot.name}") as progress:
            rows = study.run(kept, progress)
        folder.mkdir(parents=True, exist_ok=True)
        study.film(rows, folder)
        signed = {**provenance.signature(config.profile), "network": made.network}
        card = {**_card(config, series.robot), **made.facts, **signed}
        write_table(folder / f"{name}.parquet", rows, card)
        kept.clear()
    return [folder / f"{name}.parquet"]


def _card(config: Config, robot: Robot) -> dict[str, Any]:
    return provenance.card(config=config, robot=robot.name, urdf_checksum=robot.urdf_checksum)


class _Progress:
    """A bar that counts trials and says how many succeeded."""

    def __init__(self, total: int, title: str) -> None:
        self._bar = bar(total, "trial", title)
        self._successes = 0

    def __enter__(self) -> _Progress:
        self._shown = self._bar.__enter__()
        return self

    def __exit__(self, *problem: Any) -> None:
        self._bar.__exit__(*problem)

    def __call__(self, row: dict[str, Any]) -> None:
        self._successes += row["class"] == SUCCESS
        self._shown.set_postfix_str(f"{self._successes} successes", refresh=False)
        self._shown.update()
