"""Stage train: one network for one robot, from its pose sets to weights with a card."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.config import to_dict
from pipeline.data.dataset import CARD, read_split
from pipeline.data.files import read_json, write_json, write_text
from pipeline.learning.networks import build_network, parameter_count
from pipeline.learning.trainer import Run, Trainer
from pipeline.learning.weights import chain_facts, save_weights
from pipeline.seeding import derive_seed
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts, dataset_of, robot_of, trained_with
from robots import Robot


def run(config: Config) -> list[Path]:
    """Train and write weights.safetensors, card.json, metrics.json and curve.csv."""
    robot = robot_of(config)
    train, model = trained_with(config)
    folders = artifacts(config)
    data = dataset_of(config)
    folder = folders.train(robot.name, model.name)
    poses, held_out = (read_split(data, split, robot).poses for split in ("train", "validation"))
    config.train, config.model = train, model
    facts = [chain_facts(robot), to_dict(train), to_dict(model), read_json(data / CARD)["files"]]
    with exclusive(folder):
        seed = derive_seed(config.seed, "train", robot.name, model.name)
        torch.manual_seed(seed)
        network = build_network(robot, model)
        run_ = Run(
            seed=seed,
            digest=provenance.digest([facts, seed, provenance.versions()]),
            label=f"train {robot.name} {model.name}",
            checkpoint=folders.checkpoint(robot.name, model.name),
        )
        trainer = Trainer(robot, network, train, run_)
        progress = trainer.fit(poses, held_out)
        _write(folder, robot, trainer, progress.curve, held_out, config, progress.skipped)
        trainer.finish()
    return [folder]


def _write(
    folder: Path,
    robot: Robot,
    trainer: Trainer,
    curve: list[dict[str, float]],
    held_out: np.ndarray,
    config: Config,
    skipped: int,
) -> None:
    """Write curve and metrics first and the card last: a card means that the rest is there."""
    position, rotation = trainer.errors(
        torch.as_tensor(held_out, dtype=torch.float32, device=trainer.device)
    )
    metrics: dict[str, Any] = {
        "position_error_mm": float(position.mean()),
        "rotation_error_deg": float(rotation.mean()),
        "success_10mm_20deg": float(((position < 10) & (rotation < 20)).double().mean()),
        "skipped_steps": skipped,
    }
    write_text(folder / "curve.csv", pd.DataFrame(curve).to_csv(index=False))
    write_json(folder / "metrics.json", metrics)
    card = provenance.card(
        "model",
        "train",
        config=config,
        **chain_facts(robot),
        parameters=parameter_count(trainer.network),
        device=str(trainer.device),
        validation=metrics,
    )
    save_weights(folder, trainer.network, card)
