"""The raw row of a grasp trial, and the settings that it was made with."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.data.tables import read_table
from pipeline.viewing.errors import ViewError

# Columns of a row that are settings of the run, by the key that sets them.
SETTINGS = {
    "seed": "seed",
    "solver": "grasp.solver",
    "tension_scale": "grasp.tension_scale",
    "friction_scale": "grasp.friction_scale",
    "rate_hz": "grasp.physics.rate",
    "iterations": "grasp.physics.iterations",
    "placements": "grasp.placements",
    "noise_seed": "grasp.physics.noise_seed",
    "perception": "perception",
    "agent": "agent",
}
NEEDED = ("trial", "robot", "class", "reason")


def trial_row(path: Path, robot: str, trial: int) -> dict[str, Any]:
    """Return the row of a trial, the first one where a study has several.

    Args:
        path: Raw rows, CSV or Parquet.
        robot: Name of the robot.
        trial: Number of the trial.

    Raises:
        ViewError: There is no such file or no such row, or it has no rows of trials.
        TableError: A Parquet file that is damaged.
    """
    rows = _read(path)
    if missing := [name for name in NEEDED if name not in rows]:
        raise ViewError(
            f"{path} has no rows of grasp trials: it lacks the column(s) {', '.join(missing)}"
        )
    own = rows[rows["robot"] == robot]
    found = own[own["trial"] == trial]
    if found.empty:
        known = f"{own['trial'].min()} to {own['trial'].max()}" if len(own) else "none"
        raise ViewError(f"{path} has no trial {trial} of {robot}; trials of it there: {known}")
    return {str(key): value for key, value in found.iloc[0].items()}


def conditions_of(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the keys that a row was made with, as overrides of the configuration."""
    return {
        key: row[column].item() if hasattr(row[column], "item") else row[column]
        for column, key in SETTINGS.items()
        if column in row
    }


def _read(path: Path) -> pd.DataFrame:
    if path.suffix != ".csv":
        return read_table(path)
    try:
        return pd.read_csv(path)
    except (OSError, ValueError) as problem:
        raise ViewError(f"{path} cannot be read as rows of trials: {problem}") from problem
