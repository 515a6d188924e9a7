"""Stage grasp: pick-and-drop trials in simulation, held by contact and friction alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.config import to_dict
from pipeline.data.files import write_json
from pipeline.data.rows import KeptRows
from pipeline.data.tables import write_table
from pipeline.evaluation.identity import solver_identity
from pipeline.grasping import ablation
from pipeline.grasping.ablation import Study
from pipeline.grasping.outcome import SUCCESS
from pipeline.grasping.series import KEY, Series
from pipeline.grasping.trial import required_scene
from pipeline.progress import bar
from pipeline.settings import Config
from pipeline.solvers import check_solvers
from pipeline.stages.inputs import artifacts, robot_of, solver_of


def run(config: Config) -> list[Path]:
    """Write raw rows, films and the class counts of a robot's trials, or the rows of a study."""
    robot = robot_of(config)
    required_scene(config.grasp, robot.name)  # a robot without one stops here, not after training
    asked = {"grasp.solver": [config.grasp.solver]}
    if config.grasp.repair:
        asked["grasp.repair"] = [config.grasp.repair]
    study = config.grasp.ablation
    if study is not None:
        asked["grasp.ablation.vary.solver"] = list(study.vary.get("solver", []))
    check_solvers(asked, robot)
    repair = solver_of(config.grasp.repair, robot, config) if config.grasp.repair else None
    solver = solver_of(config.grasp.solver, robot, config)
    series = Series(config.grasp, robot, solver, repair, config.seed)
    if study is not None:
        return _study(config, Study(series, lambda name: solver_of(name, robot, config)))
    return _trials(config, series)


def _trials(config: Config, series: Series) -> list[Path]:
    folder = artifacts(config).grasp(series.robot.name)
    facts, path = _kept(config, series, "grasp")
    with exclusive(folder):
        kept = KeptRows(path, KEY)
        with _Progress(config.grasp.trials, f"grasp {series.robot.name}") as progress:
            rows = series.run(kept, progress)
        folder.mkdir(parents=True, exist_ok=True)
        series.film(rows, folder)
        card = _card(config, series)
        write_table(folder / "trials.parquet", rows, {**card, **facts})
        counts = {str(name): int(count) for name, count in rows["class"].value_counts().items()}
        write_json(folder / "metrics.json", counts)
        write_json(folder / "card.json", {**card, "config": {**card["config"], **facts}})
        kept.clear()
    return [folder]


def _study(config: Config, study: Study) -> list[Path]:
    series = study.series
    assert series.config.ablation is not None
    folder = artifacts(config).grasp_study(series.robot.name)
    facts, path = _kept(config, series, "study")
    name = series.config.ablation.study
    with exclusive(folder):
        kept = KeptRows(path, ablation.KEY)
        with _Progress(study.trials, f"{name} {series.robot.name}") as progress:
            rows = study.run(kept, progress)
        folder.mkdir(parents=True, exist_ok=True)
        study.film(rows, folder)
        write_table(folder / f"{name}.parquet", rows, {**_card(config, series), **facts})
        kept.clear()
    return [folder / f"{name}.parquet"]


def _kept(config: Config, series: Series, kind: str) -> tuple[dict[str, Any], Path]:
    """What the rows depend on, and the file that keeps them while they are made."""
    facts = {"grasp": {**to_dict(config.grasp), "trials": None}, "seed": config.seed}
    who = [solver_identity(each) for each in (series.solver, series.repair) if each is not None]
    made_with = [facts, series.robot.urdf_checksum, who, provenance.versions()]
    name = f"{kind}-{series.robot.name}-{provenance.digest(made_with)}.jsonl"
    return facts, artifacts(config).root / "checkpoint" / name


def _card(config: Config, series: Series) -> dict[str, Any]:
    checksum = series.robot.urdf_checksum
    return provenance.card(config=config, robot=series.robot.name, urdf_checksum=checksum)


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
