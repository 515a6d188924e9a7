"""Stage train: one network for one robot, from its pose sets to weights with a card."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
import torch

from pipeline import provenance
from pipeline.artifacts import SIGNATURE, exclusive
from pipeline.closure import source_tree
from pipeline.containers import to_dict
from pipeline.data.dataset import CARD, PoseSet, read_split
from pipeline.data.files import (
    read_json,
    replacing,
    sha256,
    write_json,
    write_sealed_json,
    write_text,
)
from pipeline.learning.card import chain_facts, read_card
from pipeline.learning.checkpoint import Progress, State
from pipeline.learning.factory import build_network, make_objective
from pipeline.learning.registry import declared_modules
from pipeline.learning.tracker import tracked
from pipeline.learning.trainer import Trainer, TrainingRun
from pipeline.learning.weights import OTHER_WEIGHTS, WEIGHTS, load_network, save_weights
from pipeline.seeding import derive_seed
from pipeline.solvers import displayed_path
from pipeline.stages.best import trained_config
from pipeline.stages.inputs import artifacts, dataset_of, robot_of
from pipeline.stages.shipped import SHIPPED, shipped_network
from robots import Robot

if TYPE_CHECKING:
    from pipeline.settings import Config

# Columns of the curve of a network that was not trained here, which has no points.
CURVE = ("step", "samples", "validation_position_error_mm", "validation_rotation_error_deg")


def check(config: Config) -> None:
    """Refuse `train.from=best` before there was a search."""
    trained_config(config)


def run(config: Config) -> list[Path]:
    """Train and write weights.safetensors, card.json, metrics.json and curve.csv.

    The last network is kept or the best, as `train.keep` says; other.safetensors is the other one.
    With `train.from=shipped` it is the network of the project, if that is what would be trained.
    """
    robot = robot_of(config)
    config = trained_config(config)
    folders = artifacts(config)
    data = dataset_of(config)
    folder = folders.train(robot.name, config.model.name)
    if config.train.source == SHIPPED and (shipped := shipped_network(config)) is not None:
        with exclusive(folder):
            _take(shipped, folder, robot, read_split(data, "validation", robot), config)
        return [folder]
    poses, held_out = (read_split(data, split, robot) for split in ("train", "validation"))
    poses = poses.first(config.train.poses)
    seed = derive_seed(config.seed, "train", robot.name, config.model.name, config.train.replicate)
    facts = [chain_facts(robot), to_dict(config.train), to_dict(config.model), seed]
    made_with = [facts, read_json(data / CARD)["files"], provenance.versions()]
    digest = provenance.digest(made_with)
    code = source_tree().digest(__name__, *declared_modules(config.model.kind))
    resumed = provenance.digest([digest, code])
    with exclusive(folder) as waited:
        if waited and _made(folder) == digest:
            return [folder]  # the run that was waited for made just this
        torch.manual_seed(seed)
        checkpoint = folders.checkpoint(robot.name, config.model.name)
        label = f"train {robot.name} {config.model.name}"
        settings = {"seed": seed, "train": to_dict(config.train), "model": to_dict(config.model)}
        with tracked(config.tracker, folders.tracker(), label, settings) as report:
            trainer = Trainer(
                robot,
                build_network(robot, config.model),
                config.train,
                TrainingRun(seed, resumed, label, checkpoint, report),
            )
            progress = trainer.fit(poses, held_out)
        _write(folder, robot, trainer, progress, held_out, config, digest)
        trainer.finish()
    return [folder]


def _take(shipped: Path, folder: Path, robot: Robot, held_out: PoseSet, config: Config) -> None:
    """Put the project's network where a training would leave one, with its errors measured here.

    It comes alone: other.safetensors is the same network, and curve.csv has no points.
    """
    network = load_network(shipped, robot)
    objective = make_objective(robot, network, config.train, torch.device("cpu"))
    poses = torch.as_tensor(held_out.poses, dtype=torch.float32)
    metrics = error_means(*objective.errors(poses))
    for name in (WEIGHTS, OTHER_WEIGHTS):
        with replacing(folder / name) as partial:
            shutil.copyfile(shipped / WEIGHTS, partial)
    write_text(folder / "curve.csv", ",".join(CURVE) + "\n")
    write_json(folder / "metrics.json", metrics)
    write_json(folder / SIGNATURE, provenance.signature(config.profile))
    card = {**read_card(shipped), "validation": metrics, SHIPPED: displayed_path(shipped)}
    card["files"] = {name: sha256(folder / name) for name in ("curve.csv", "metrics.json")}
    write_sealed_json(folder / CARD, card)


def _made(folder: Path) -> str:
    """Digest of the run whose weights lie in a folder; empty where there are none."""
    return str(read_card(folder).get("run")) if (folder / CARD).exists() else ""


def _write(
    folder: Path,
    robot: Robot,
    trainer: Trainer,
    progress: Progress,
    held_out: PoseSet,
    config: Config,
    digest: str,
) -> None:
    """Write curve and metrics first and the card last: a card means that the rest is there.

    The digest of the run in the card is that of data and values: later stages depend on the card,
    and code that trains the same weights leaves the same one. A checkpoint knows its code as well.
    """
    states, kept = trainer.states(), config.train.keep
    errors = {name: _errors(trainer, state, held_out) for name, state in states.items()}
    trainer.network.load_state_dict(states[kept])
    metrics: dict[str, Any] = {
        **errors[kept],
        "skipped_steps": progress.skipped,
        "last": errors["last"],
        "best": {**errors["best"], "step": progress.best_step},
    }
    write_text(folder / "curve.csv", pd.DataFrame(progress.curve).to_csv(index=False))
    write_json(folder / "metrics.json", metrics)
    write_json(folder / SIGNATURE, _signature(trainer, progress, config))
    card = provenance.card(
        "model",
        "train",
        config=config,
        **trainer.facts(robot),
        run=digest,
        kept=kept,
        validation=metrics,
        files={name: sha256(folder / name) for name in ("curve.csv", "metrics.json")},
    )
    save_weights(folder, trainer.network, card, states["best" if kept == "last" else "last"])


def _signature(trainer: Trainer, progress: Progress, config: Config) -> dict[str, Any]:
    """What no later stage may depend on: when it was made, by what, and how long it took."""
    seconds = round(progress.processor_s, 1)
    made = provenance.signature(config.profile)
    return {**made, "processor_s": seconds, "device": str(trainer.device)}


def _errors(trainer: Trainer, state: State, held_out: PoseSet) -> dict[str, float]:
    """Mean errors of a network's tensors on the validation set."""
    trainer.network.load_state_dict(state)
    return error_means(*trainer.objective.errors(trainer.tensor(held_out.poses)))


def error_means(position: torch.Tensor, rotation: torch.Tensor) -> dict[str, float]:
    """Mean of errors in mm and deg, and the share within 10 mm and 20 deg.

    Args:
        position: Euclidean errors [mm], (N,).
        rotation: Geodesic errors [deg], (N,).
    """
    return {
        "position_error_mm": float(position.mean()),
        "rotation_error_deg": float(rotation.mean()),
        "success_10mm_20deg": float(((position < 10) & (rotation < 20)).double().mean()),
    }
