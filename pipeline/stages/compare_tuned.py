"""Stage compare-tuned: the best of a search against Table I, at one budget of training.

Run `tune` before it and `report` after it: the report states the intervals.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.containers import to_dict
from pipeline.data.dataset import read_split
from pipeline.data.tables import write_table
from pipeline.stages.inputs import artifacts, dataset_of, robot_of
from pipeline.tuning.comparison import BEST, load_candidates, run_comparison

if TYPE_CHECKING:
    from pipeline.settings import Config


def run(config: Config) -> list[Path]:
    """Write raw rows, one a training; goes on where it was stopped."""
    robot = robot_of(config)
    folders = artifacts(config)
    best = folders.tune(robot.name) / "best.yaml"
    if BEST in config.tune.comparison.candidates:
        command = f"python -m pipeline tune robot={robot.name} profile={config.profile}"
        best = folders.need(best, command)
    chosen = load_candidates(config, best)
    data = dataset_of(config)
    sets = read_split(data, "train", robot), read_split(data, "validation", robot)
    path = folders.compare_tuned(robot.name)
    facts = {**provenance.made_by(), "commit": provenance.commit(), "profile": config.profile}
    facts |= {"comparison": to_dict(config.tune.comparison), "seed": config.seed}

    def keep(rows: pd.DataFrame) -> None:
        write_table(path, rows, facts)

    with exclusive(path):
        keep(run_comparison(robot, config, chosen, sets, path, keep))
    return [path]
