"""Table III with rows of our own: every learned method on the same poses, with equal training time.

    python -m benchmarks.table_three [--minutes 3.5] [--robots panda valkyrie] [key=value ...]

Each method is trained for the same time of one core, by the rates of results/rates.csv; that of the
compact network of CycleIK, which comes with the project. Trainings that ended with these lengths are
kept and one that was stopped goes on, so the command may be killed and given again.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from math import ceil
from pathlib import Path

from pipeline.config import compose
from pipeline.learning.card import CARD, read_card
from pipeline.settings import Config
from pipeline.stages.forecast import core_seconds
from pipeline.stages.inputs import artifacts
from pipeline.stages.running import run_stage

METHODS = {  # by robot, those that the paper or its related work has numbers for
    "panda": ("gan", "iknet", "flow", "node_ik", "eem"),
    "valkyrie": ("flow", "eem"),
}
COMPACT_MINUTES = 3.5  # of one core, what the recipe of the compact network takes


def main() -> None:
    """Train, measure, print and, if asked, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--minutes", type=float, default=COMPACT_MINUTES)
    parser.add_argument("--robots", nargs="+", choices=METHODS, default=[*METHODS])
    parser.add_argument("overrides", nargs="*", help="such as results_dir=results/slow")
    options = parser.parse_args()
    for robot in options.robots:
        for model in METHODS[robot]:
            print(trained(robot, model, options.minutes, options.overrides), flush=True)


def trained(robot: str, model: str, minutes: float, overrides: Sequence[str]) -> Path:
    """Return the folder of a method's weights, trained for so many minutes of a core."""
    config = with_length(robot, model, minutes, overrides)
    folder = artifacts(config).train(robot, model)
    if (folder / CARD).exists():
        made = read_card(folder)["config"]["train"]
        if (made["poses"], made["epochs"]) == (config.train.poses, config.train.epochs):
            return folder
    run_stage("train", config)
    return folder


def with_length(robot: str, model: str, minutes: float, overrides: Sequence[str]) -> Config:
    """Return the configuration of a training of so many minutes of a core.

    It goes through the poses of the training set as few times as it can: where the profile's recipe
    takes a few of them many times, that is to make it short.
    """
    given = [*overrides, f"robot={robot}", f"model={model}"]
    whole = compose([*given, "train.poses=0", "train.epochs=1"])
    start_s = core_seconds("start", whole)
    pose_s = (core_seconds("train", whole) - start_s) / whole.dataset.train
    seen = 60 * minutes / pose_s
    epochs = ceil(seen / whole.dataset.train)
    return compose([*given, f"train.poses={int(seen / epochs)}", f"train.epochs={epochs}"])


if __name__ == "__main__":
    main()
