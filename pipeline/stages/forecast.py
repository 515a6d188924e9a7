"""What a step of the graph will take: core hours by the rates that were measured and committed."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import pandas as pd

from pipeline.locations import results

if TYPE_CHECKING:
    from pipeline.settings import Config

RATES = "rates.csv"  # below results/: core seconds a unit, where they were measured, by what
SECONDS_PER_HOUR = 3600.0


@cache
def rates() -> pd.DataFrame:
    """Return the committed rates; an empty cell of `what` or `robot` stands for any."""
    return pd.read_csv(results() / RATES, keep_default_na=False)


def core_hours(stage: str, config: Config) -> float:
    """Return what one run of a stage is expected to take, in hours of one core.

    Args:
        stage: Name of the stage.
        config: Of the run.
    """
    if stage == "tune":
        tune = config.tune
        poses = (tune.poses or config.dataset.train) * tune.epochs * tune.trials
        return _hours("train", config.model.name, config.robot.name, poses)
    what, units = _units(stage, config)
    return _hours(stage, what, config.robot.name, units)


def _units(stage: str, config: Config) -> tuple[str, float]:
    """What the rate depends on besides the robot, and how many units a run has."""
    data, evaluate = config.dataset, config.evaluate
    if stage == "dataset":
        return "", data.train + data.validation + data.test
    if stage == "train":
        return config.model.name, (config.train.poses or data.train) * config.train.epochs
    if stage == "evaluate":
        (solver,) = evaluate.solvers
        slow = solver == "cycleik" and config.model.name == "paper"
        return solver if slow else "", evaluate.poses or data.test
    if stage == "plan":
        return "", config.plan.pairs * len(config.plan.solvers)
    return "", config.grasp.trials if stage == "grasp" else 1


def _hours(stage: str, what: str, robot: str, units: float) -> float:
    """Units at the most special rate there is: of what and robot, of what, of the stage."""
    mine = rates()[rates().stage == stage]
    for names in ((what, robot), (what, ""), ("", "")):
        found = mine[(mine.what == names[0]) & (mine.robot == names[1])]
        if len(found):
            return float(found.core_seconds.iloc[0]) * units / SECONDS_PER_HOUR
    return 0.0
