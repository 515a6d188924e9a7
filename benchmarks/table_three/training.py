"""Trainings of equal time: how long they are in poses, and what was said of them afterwards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pipeline.artifacts import SIGNATURE
from pipeline.config import compose
from pipeline.data.files import read_json
from pipeline.learning.card import CARD, read_card
from pipeline.stages.forecast import with_minutes
from pipeline.stages.inputs import artifacts
from pipeline.stages.running import run_stage


@dataclass(frozen=True)
class Training:
    """What a network was trained with.

    Attributes:
        parameters: Weights and biases.
        poses: Poses seen, one as often as it was seen.
        seconds: Processor time [s]; None where it was not recorded.
        device: Of the training.
    """

    parameters: int
    poses: int
    seconds: float | None
    device: str


def trained(
    robot: str, model: str, minutes: float, overrides: Sequence[str], as_is: bool
) -> Path | None:
    """Return the folder of a method's weights, trained for so many minutes of a core.

    Weights of that length are taken as they are; a training that was stopped goes on. With
    ``as_is`` nothing is trained, and there is None where there are no such weights.
    """
    config = with_minutes(minutes, compose([*overrides, f"robot={robot}", f"model={model}"]))
    folder = artifacts(config).train(robot, model)
    if (folder / CARD).exists():
        made = read_card(folder)["config"]["train"]
        if (made["poses"], made["epochs"]) == (config.train.poses, config.train.epochs):
            return folder
    if as_is:
        return None
    run_stage("train", config)
    return folder


def training_of(folder: Path) -> Training:
    """Return what card and signature say of the weights in a folder.

    The project's own say no time, and their best step is their last.
    """
    card, train = read_card(folder), read_card(folder)["config"]["train"]
    signed = read_json(folder / SIGNATURE) if (folder / SIGNATURE).exists() else {}
    seen = train.get("poses", 0) * train["epochs"]
    return Training(
        parameters=card["parameters"],
        poses=seen or card["validation"]["best"]["step"] * train["batch_size"],
        seconds=signed.get("processor_s"),
        device=card["device"],
    )
