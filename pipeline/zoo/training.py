"""The compact network of an arm, trained for some minutes; one that was stopped goes on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import torch

from pipeline import provenance
from pipeline.closure import source_tree
from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.data.dataset import PoseSet
from pipeline.learning.card import CARD, chain_facts, read_card
from pipeline.learning.factory import build_network
from pipeline.learning.registry import declared_modules
from pipeline.learning.trainer import Trainer, TrainingRun
from pipeline.learning.weights import save_weights
from pipeline.seeding import derive_seed
from pipeline.stages.forecast import with_minutes
from pipeline.zoo.arms import ZooConfig
from robots import Robot

MODEL = "compact"
ERRORS = ("validation_position_error_mm", "validation_rotation_error_deg")  # of a curve


@dataclass(frozen=True)
class Trained:
    """A network and what it took.

    Attributes:
        folder: Of weights.safetensors and card.json.
        processor_s: Processor time of the training [s].
        position_mm: Mean Euclidean error on the validation poses.
        rotation_deg: Mean geodesic error there.
    """

    folder: Path
    processor_s: float
    position_mm: float
    rotation_deg: float


def trained(robot: Robot, folder: Path, zoo: ZooConfig) -> Trained:
    """Train a network for a robot, or take the one that was trained so before.

    Args:
        robot: The robot.
        folder: Where weights and card come; the checkpoint lies beside them.
        zoo: Minutes, poses and seed.
    """
    size = f"dataset.train={zoo.train}"
    config = with_minutes(zoo.minutes, compose([f"model={MODEL}", "train.device=cpu", size]))
    seed = derive_seed(zoo.seed, "zoo", robot.name)
    made_of = [chain_facts(robot), to_dict(config.train), to_dict(config.model), seed, zoo.train]
    digest = provenance.digest([made_of, zoo.validation, provenance.versions()])
    if not (folder / CARD).exists() or read_card(folder)["run"] != digest:
        code = source_tree().digest(__name__, *declared_modules(config.model.kind))
        torch.manual_seed(seed)
        run = TrainingRun(
            seed,
            provenance.digest([digest, code]),
            f"train {robot.name}",
            folder.with_suffix(".checkpoint.safetensors"),
        )
        trainer = Trainer(robot, build_network(robot, config.model), config.train, run)
        sets = (("train", config.train.poses), ("validation", zoo.validation))
        progress = trainer.fit(*(_poses(robot, n, derive_seed(seed, name)) for name, n in sets))
        card = provenance.card(
            "model",
            "train",
            config=config,
            **trainer.facts(robot),
            run=digest,
            validation=progress.curve[-1],
            processor_s=round(progress.processor_s, 1),
        )
        save_weights(folder, trainer.network, card)
        trainer.finish()
    card = read_card(folder)
    errors = (card["validation"][name] for name in ERRORS)
    return Trained(folder, card["processor_s"], *errors)


def _poses(robot: Robot, count: int, seed: int) -> PoseSet:
    joints = robot.sample(count, seed=seed)
    return PoseSet(robot.forward_kinematics(joints), joints)
