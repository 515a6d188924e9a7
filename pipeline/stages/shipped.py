"""The networks that come with the project, where a run would train just those."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.learning.card import CARD, read_card, shipped_weights

if TYPE_CHECKING:
    from pipeline.settings import Config

SHIPPED = "shipped"  # value of train.from and detector.from, and key of the cards of such networks


def shipped_network(config: Config) -> Path | None:
    """Return the folder of the project's weights where they are what a run would train.

    That is a network of the run's model, with nothing of its training overridden; else None.
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
    card = read_card(folder)
    return folder if unchanged and agree(card["config"]["model"], wanted["model"]) else None


def shipped_eyes(config: Config) -> Path | None:
    """Return the folder of the project's detector where it is of a run's objects and network."""
    from pipeline.grasping.trial import required_scene  # PyBullet and torch, for detectors only
    from pipeline.perception.weights import shipped_detector

    folder = shipped_detector(config.robot.name)
    if not (folder / CARD).exists():
        return None
    card = read_card(folder)
    names = list(required_scene(config.grasp, config.robot.name).objects)
    same_network = agree(card["config"]["detector"]["network"], to_dict(config.detector.network))
    return folder if same_network and sorted(card["names"]) == sorted(names) else None


def agree(theirs: dict[str, Any], ours: dict[str, Any]) -> bool:
    """Whether a card has our values; cards of earlier versions hold the keys of all networks."""
    return all(theirs.get(key) == value for key, value in ours.items())
