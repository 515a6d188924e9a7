"""What the runs of sweeps left: cards, curves, and the joints that their networks answer."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.artifacts import SIGNATURE
from pipeline.data.files import check_listed, read_json
from pipeline.data.tables import read_table


@dataclass(frozen=True)
class SweptRun:
    """One training of a sweep.

    Attributes:
        folder: Results folder of the run.
        card: Card of the weights, with day and commit where they were recorded.
        curve: Errors on the validation set while it was trained.
    """

    folder: Path
    card: dict[str, Any]
    curve: pd.DataFrame

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return str(self.card["robot"])

    @property
    def model(self) -> str:
        """Name of the model."""
        return str(self.card["config"]["model"]["name"])

    @property
    def train(self) -> dict[str, Any]:
        """Configuration of the training."""
        return dict(self.card["config"]["train"])

    def likeness(self, varied: tuple[str, ...]) -> str:
        """Return what runs share that differ at most in replicate, seed and keys of ``train``."""
        train = {key: v for key, v in self.train.items() if key not in (*varied, "replicate")}
        model, versions = self.card["config"]["model"], self.card.get("versions")
        return json.dumps([self.robot, model, train, versions], sort_keys=True, default=str)

    def answers(self, solver: str) -> pd.DataFrame | None:
        """Raw rows of a solver on the test poses, joints included; None where there are none.

        Of several batch sizes the one that answered most poses is taken.
        """
        path = self.folder / "evaluate" / self.robot / f"{solver}.parquet"
        if not path.exists():
            return None
        rows = read_table(path)
        sizes = rows.batch_size.value_counts()
        return rows[rows.batch_size == sizes[sizes == sizes.max()].index.min()]


def read_sweeps(folder: Path) -> tuple[list[SweptRun], list[str]]:
    """Read every training below the sweeps of a results folder.

    Returns:
        The runs in the order of their folders, and a sentence for each that cannot be read.
    """
    runs, notes = [], []
    for path in sorted((folder / "sweep").glob("*/train/*/*/card.json")):
        try:
            card = dict(read_json(path))
            if (signed := path.with_name(SIGNATURE)).exists():
                card |= read_json(signed)
            _ = card["robot"], card["config"]["train"], card["config"]["model"]["name"]
            curve = path.with_name("curve.csv")
            check_listed(curve, card)
            runs.append(SweptRun(path.parents[3], card, pd.read_csv(curve)))
        except (ValueError, OSError) as error:
            notes.append(f"{path.relative_to(folder)} could not be read: {error}.")
    return runs, notes


def alike(runs: list[SweptRun], varied: tuple[str, ...]) -> list[list[SweptRun]]:
    """Group runs that differ at most in ``varied`` keys of the training, seed and replicate."""
    groups: dict[str, list[SweptRun]] = {}
    for run in runs:
        groups.setdefault(run.likeness(varied), []).append(run)
    return list(groups.values())
