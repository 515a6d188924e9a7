"""Stage compare-tuned: the best of a search against Table I, at one budget of training.

Run `tune` before it and `report` after it: the report states the intervals.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.data.dataset import read_split
from pipeline.data.tables import write_table
from pipeline.stages.inputs import artifacts, dataset_of, robot_of
from pipeline.tuning.comparison import BEST, Candidate, load_candidates, run_comparison

if TYPE_CHECKING:
    from pipeline.settings import Config


def check(config: Config) -> None:
    """Refuse to compare what a search found before there was one."""
    _candidates(config)


def run(config: Config) -> list[Path]:
    """Write raw rows, one a training; goes on where it was stopped."""
    robot, folders = robot_of(config), artifacts(config)
    chosen = _candidates(config)
    data = dataset_of(config)
    sets = read_split(data, "train", robot), read_split(data, "validation", robot)
    path = folders.compare_tuned(robot.name)
    facts = {**provenance.made_by(), **provenance.signature(config.profile)}
    facts |= {"comparison": to_dict(config.tune.comparison), "seed": config.seed}

    def keep(rows: pd.DataFrame) -> None:
        write_table(path, rows, facts)

    with exclusive(path):
        keep(run_comparison(robot, config, chosen, sets, path, keep))
    return [path]


def _candidates(config: Config) -> list[Candidate]:
    folders = artifacts(config)
    best = folders.tune(robot_of(config).name) / "best.yaml"
    if BEST in config.tune.comparison.candidates:
        command = f"python -m pipeline tune robot={config.robot.name} profile={config.profile}"
        best = folders.need(best, command)
    return load_candidates(config, best, compose)
