"""The card beside trained weights: what they are for, read without torch."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import robots
from pipeline.data.files import read_json
from robots import Robot
from robots.checksums import chain_checksum

CARD = "card.json"
ROBOTS = Path(robots.__file__).parent


class WeightsError(ValueError):
    """Weights that are missing, damaged, or belong to another robot."""


def shipped_weights(robot: str) -> Path:
    """Return the folder of the weights that come with this project for a robot."""
    return ROBOTS / robot / "weights"


def read_card(folder: Path) -> dict[str, Any]:
    """Return the card of trained weights.

    Raises:
        WeightsError: There is none.
    """
    if not (folder / CARD).exists():
        raise WeightsError(f"there are no trained weights in {folder}")
    return dict(read_json(folder / CARD))


def kind_of(folder: Path) -> str:
    """Return the kind of network (``model.kind``) of trained weights; empty if the card lacks it.

    Raises:
        WeightsError: There are no weights.
    """
    return str(read_card(folder).get("config", {}).get("model", {}).get("kind", ""))


def chain_facts(robot: Robot) -> dict[str, Any]:
    """Return what a card says of the robot: enough to refuse weights of another one."""
    return {
        "robot": robot.name,
        "joint_names": list(robot.joint_names),
        "base": robot.base,
        "tip": robot.tip,
        "chain_checksum": chain_checksum(robot),
    }


def check_robot(folder: Path, card: dict[str, Any], robot: Robot) -> None:
    """Refuse weights of another robot or chain.

    Raises:
        WeightsError: They are.
    """
    for key, ours in chain_facts(robot).items():
        if card.get(key) != ours:
            raise WeightsError(
                f"the weights in {folder} are for another robot: {key} is {card.get(key)!r} there, "
                f"{ours!r} here; train with: python -m pipeline train robot={robot.name}"
            )
