"""Stage dataset: collision-filtered uniform samples as train, validation and test poses."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline import provenance
from pipeline.artifacts import SPLITS, exclusive
from pipeline.closure import source_tree
from pipeline.data.chunk_executor import chunk_executor
from pipeline.data.croissant import CROISSANT, croissant
from pipeline.data.dataset import CARD, split_seed, write_card, write_split
from pipeline.data.files import FileError, read_json, write_json, write_sealed_json
from pipeline.data.tables import TableError, read_metadata, read_table
from pipeline.progress import bar
from pipeline.stages.inputs import artifacts, dataset_facts, robot_of
from robots import Robot
from robots.checksums import sampling_checksum
from robots.sampling import sample_configurations

if TYPE_CHECKING:
    from pipeline.settings import Config


def run(config: Config) -> list[Path]:
    """Write the three pose sets of a robot and their card.

    Splits that a killed run had finished are kept: they carry the facts that they were made with.
    """
    robot = robot_of(config)
    folder = artifacts(config).dataset(robot.name)
    with exclusive(folder):
        (folder / CARD).unlink(missing_ok=True)
        _drop_other_code(
            folder, artifacts(config).root / "checkpoint" / f"dataset-{robot.name}.json"
        )
        facts = {split: _make(folder, robot, split, config) for split in SPLITS}
        card = {**_robot_facts(robot), "config": dataset_facts(config), "splits": facts}
        write_card(folder, {**card, **provenance.made_by()}, SPLITS)
        write_json(folder / CROISSANT, croissant(read_json(folder / CARD), robot))
    return [folder]


def _drop_other_code(folder: Path, note: Path) -> None:
    """Remove splits that other code made; the note says which code made those that are there.

    It lies outside the artifact: later stages depend on poses, and the same poses are the same
    artifact whatever code made them.
    """
    code = source_tree().digest(__name__)
    if _noted(note) != code:
        for split in SPLITS:
            (folder / f"{split}.parquet").unlink(missing_ok=True)
        write_sealed_json(note, {"code": code})


def _noted(note: Path) -> str:
    try:
        return str(read_json(note).get("code"))
    except (FileNotFoundError, FileError):
        return ""


def _make(folder: Path, robot: Robot, split: str, config: Config) -> dict[str, Any]:
    path = folder / f"{split}.parquet"
    count = getattr(config.dataset, split)
    wanted = {
        **_robot_facts(robot),
        "split": split,
        "poses": count,
        "seed": split_seed(config.seed, robot.name, split),
        "workspace_filter": config.robot.workspace_filter,
        "numpy": provenance.versions()["numpy"],
    }
    kept = _kept(path, wanted)
    if kept is not None:
        return kept
    with bar(count, "pose", f"dataset {robot.name} {split}") as shown:
        samples = sample_configurations(
            robot,
            count,
            seed=wanted["seed"],
            workspace_filter=config.robot.workspace_filter,
            executor=chunk_executor(config.engine, config.dataset.workers),
            progress=shown.update,
        )
    facts = {
        **wanted,
        "acceptance": round(samples.acceptance, 6),
        "drawn": samples.drawn,
        "outside_workspace": samples.outside,
        "in_collision": samples.colliding,
    }
    write_split(path, robot, samples.joints, facts)
    return facts


def _kept(path: Path, wanted: dict[str, Any]) -> dict[str, Any] | None:
    """Return the facts of a finished split that was made with the same inputs, else None."""
    try:
        facts = read_metadata(path)
        if {key: facts.get(key) for key in wanted} != wanted:
            return None
        read_table(path)
    except TableError:
        return None
    return facts


def _robot_facts(robot: Robot) -> dict[str, Any]:
    return {"robot": robot.name, "checksum": sampling_checksum(robot)}
