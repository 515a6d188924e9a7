"""Stage grasp: pick-and-drop trials in simulation, held by contact and friction alone."""

from __future__ import annotations

from pathlib import Path

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.config import to_dict
from pipeline.data.files import write_json
from pipeline.data.rows import KeptRows
from pipeline.data.tables import write_table
from pipeline.evaluation.identity import solver_identity
from pipeline.grasping.outcome import SUCCESS
from pipeline.grasping.series import KEY, Series
from pipeline.grasping.trial import required_scene
from pipeline.progress import bar
from pipeline.settings import Config
from pipeline.solvers import check_solvers
from pipeline.stages.inputs import artifacts, robot_of, solver_of


def run(config: Config) -> list[Path]:
    """Write raw rows, films and the class counts of a robot's trials."""
    robot = robot_of(config)
    required_scene(config.grasp, robot.name)  # a robot without one stops here, not after training
    asked = {"grasp.solver": [config.grasp.solver]}
    if config.grasp.repair:
        asked["grasp.repair"] = [config.grasp.repair]
    check_solvers(asked, robot)
    repair = solver_of(config.grasp.repair, robot, config) if config.grasp.repair else None
    solver = solver_of(config.grasp.solver, robot, config)
    series = Series(config.grasp, robot, solver, repair, config.seed)
    folders = artifacts(config)
    folder = folders.grasp(robot.name)
    facts = {"grasp": {**to_dict(config.grasp), "trials": None}, "seed": config.seed}
    who = [solver_identity(each) for each in (solver, repair) if each is not None]
    digest = provenance.digest([facts, robot.urdf_checksum, who, provenance.versions()])
    path = folders.root / "checkpoint" / f"grasp-{robot.name}-{digest}.jsonl"
    with exclusive(folder), bar(config.grasp.trials, "trial", f"grasp {robot.name}") as shown:
        successes = 0
        kept = KeptRows(path, KEY)

        def progress(row: dict[str, object]) -> None:
            nonlocal successes
            successes += row["class"] == SUCCESS
            shown.set_postfix_str(f"{successes} successes", refresh=False)
            shown.update()

        rows = series.run(kept, progress)
        folder.mkdir(parents=True, exist_ok=True)
        series.film(rows, folder)
        card = provenance.card(config=config, robot=robot.name, urdf_checksum=robot.urdf_checksum)
        write_table(folder / "trials.parquet", rows, {**card, **facts})
        counts = {str(name): int(count) for name, count in rows["class"].value_counts().items()}
        write_json(folder / "metrics.json", counts)
        write_json(folder / "card.json", {**card, "config": {**card["config"], **facts}})
        kept.clear()
    return [folder]
