"""What a task is expected to take: core seconds by the rates that were measured and committed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from math import ceil
from typing import TYPE_CHECKING

import pandas as pd

from pipeline.config import compose
from pipeline.errors import PipelineError
from pipeline.locations import rates_file
from pipeline.stages.shipped import SHIPPED

if TYPE_CHECKING:
    from pipeline.settings import Config

START = "start"  # row of what any command takes before its first unit
ROBOT, SOLVERS = "robot", "evaluate.solvers"
ASIDE = (ROBOT, SOLVERS, "evaluate.seeded_by", "evaluate.side_by_side")  # keys that change no size


@cache
def rates() -> pd.DataFrame:
    """Return the committed rates; an empty cell of `what` or `robot` stands for any."""
    return pd.read_csv(rates_file(), keep_default_na=False)


def core_seconds(stage: str, config: Config) -> float:
    """Return what one run of a stage is expected to take, in seconds of one core.

    Args:
        stage: Name of the stage.
        config: Of the run.
    """
    what, units = _units(stage, config)
    robot = config.robot.name
    rate = _rate(stage, what, robot)
    if rate is None and stage == "tune":
        rate = _rate("train", what, robot)
    return (_rate(START, "", "") or 0.0) + (rate or 0.0) * units


def seconds_of_command(stage: str, overrides: Sequence[str]) -> float:
    """Return the same for a command.

    Args:
        stage: Name of the stage.
        overrides: Its further words.
    """
    given = dict(item.split("=", 1) for item in overrides)
    config = _sizes(tuple(item for item in overrides if item.split("=")[0] not in ASIDE))
    robot = replace(config.robot, name=given.get(ROBOT, config.robot.name))
    evaluate = config.evaluate
    if SOLVERS in given:
        evaluate = replace(evaluate, solvers=given[SOLVERS].strip("[]").split(","))
    return core_seconds(stage, replace(config, robot=robot, evaluate=evaluate))


def with_minutes(minutes: float, config: Config) -> Config:
    """Return a run whose training takes so many minutes of one core, by the committed rates.

    Its length does not depend on the machine. It goes through the training set as few times as it
    can: that the recipe of a profile takes a few poses many times is to make it short.

    Raises:
        PipelineError: There is no rate for the model.
    """
    rate = _rate("train", config.model.name, config.robot.name)
    if not rate:
        raise PipelineError(f"{rates_file()} has no rate of training for {config.model.name}")
    seen = 60 * minutes / rate
    epochs = ceil(seen / config.dataset.train)
    poses = max(config.train.batch_size, int(seen / epochs))
    return replace(config, train=replace(config.train, poses=poses, epochs=epochs))


@cache
def _sizes(overrides: tuple[str, ...]) -> Config:
    """Compose once for many tasks: it takes most of a second, and there are a hundred of them."""
    return compose(overrides)


def _units(stage: str, config: Config) -> tuple[str, float]:
    """What the rate depends on besides the robot, and how many units a run has."""
    data, evaluate, model = config.dataset, config.evaluate, config.model.name
    detector, tune = config.detector, config.tune
    if stage == "dataset":
        return "", data.train + data.validation + data.test
    if stage == "tune":
        return model, _of(tune.poses, data.train) * tune.epochs * tune.trials
    if stage == "train":
        if config.train.source == SHIPPED:
            return SHIPPED, 1
        return model, _of(config.train.poses, data.train) * config.train.epochs
    if stage == "evaluate":
        solver = evaluate.solvers[0]
        fast = solver == "cycleik" and model != "paper"  # rates of the name are Table I's network's
        return "" if fast else solver, _of(evaluate.poses, data.test) * len(evaluate.solvers)
    if stage == "plan":
        return "", config.plan.pairs * len(config.plan.solvers)
    if stage == "detector":
        if detector.source == SHIPPED:
            return SHIPPED, detector.held_out_pictures
        return "", detector.pictures * detector.epochs
    if stage == "grasp":
        return config.agent.kind, config.grasp.trials
    return "", 1


def _of(wanted: int, there_are: int) -> int:
    """How many poses of a set are taken; 0 takes all."""
    return min(wanted or there_are, there_are)


def _rate(stage: str, what: str, robot: str) -> float | None:
    """The most special rate there is [s]: of what and robot, of what, of the stage."""
    mine = rates()[rates().stage == stage]
    for names in ((what, robot), (what, ""), ("", "")):
        found = mine[(mine.what == names[0]) & (mine.robot == names[1])]
        if len(found):
            return float(found.core_seconds.iloc[0])
    return None
