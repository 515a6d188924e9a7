"""The networks that come with the project, where a run would train just those."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.learning.card import CARD, read_card, shipped_weights
from pipeline.learning.config import TrainConfig
from pipeline.perception.config import DetectorConfig

if TYPE_CHECKING:
    from pipeline.settings import Config

# What of a recipe decides which network comes of it besides how long; the rest says how it is run.
ASIDE = {"epochs", "source", "device", "kinematics", "step", "validations", "checkpoint_s"}
SHAPING = sorted({field.name for field in fields(TrainConfig)} - ASIDE)
ASIDE_EYES = {
    *("pictures", "epochs", "source", "chunk", "checkpoint_epochs"),
    *("held_out_pictures", "held_out", "match_overlap", "figure_pictures"),
}
SHAPING_EYES = sorted({field.name for field in fields(DetectorConfig)} - ASIDE_EYES)
SHIPPED = "shipped"  # value of train.from and detector.from, and key of the cards of such networks


def shipped_network(config: Config) -> Path | None:
    """Return the folder of the project's weights where they are what a run would train.

    That is a network of the run's model, with nothing of its training overridden, neither on the
    command line nor by an edit of conf/, and trained at least as long; else None.
    """
    folder = shipped_weights(config.robot.name)
    if not (folder / CARD).exists():
        return None
    names = [f"robot={config.robot.name}", f"profile={config.profile}"]
    plain = to_dict(compose([*names, f"model={config.model.name}"]))
    wanted = to_dict(config)
    for values in (plain, wanted):
        values["train"]["source"] = None
    unchanged = all(wanted[key] == plain[key] for key in ("seed", "train", "model"))
    card = read_card(folder)["config"]
    recipe = {key: wanted["train"][key] for key in SHAPING if key in card["train"]}
    same = agree(card["model"], wanted["model"]) and agree(card["train"], recipe)
    long_enough = card["train"]["epochs"] >= wanted["train"]["epochs"]
    return folder if unchanged and same and long_enough else None


def shipped_eyes(config: Config) -> Path | None:
    """Return the folder of the project's detector where it is what a run would train.

    That is one of its objects, network and recipe, trained at least as long; else None.
    """
    from pipeline.grasping.trial import required_scene  # PyBullet and torch, for detectors only
    from pipeline.perception.weights import shipped_detector

    folder = shipped_detector(config.robot.name)
    if not (folder / CARD).exists():
        return None
    card = read_card(folder)
    names = list(required_scene(config.grasp, config.robot.name).objects)
    trained, wanted = card["config"]["detector"], to_dict(config.detector)
    same = agree(trained, {key: wanted[key] for key in SHAPING_EYES})
    long_enough = all(trained[key] >= wanted[key] for key in ("pictures", "epochs"))
    return folder if same and long_enough and sorted(card["names"]) == sorted(names) else None


def agree(theirs: dict[str, Any], ours: dict[str, Any]) -> bool:
    """Whether a card has our values; cards of earlier versions hold the keys of all networks."""
    return all(theirs.get(key) == value for key, value in ours.items())
