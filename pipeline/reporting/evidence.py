"""What lies on disk to judge the paper by: tables that reports made, and settings taken over."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path

import pandas as pd
from scipy import stats

from pipeline.evaluation.statistics import wilson_interval
from pipeline.presentation.naming import robot_title, solver_title

CONFIDENCE = 0.95
CAMERA_AND_AGENT = "camera, embedded policy"  # the setting of the trials that figure 5 is of


@dataclass(frozen=True)
class Measured:
    """A number of ours, in the unit of the published one.

    Attributes:
        value: The number; a text where the published one is one, such as neurons by layer.
        rows: File that it was read from, seen from the results folder; empty for a setting.
        low: Lower end of its 95 % interval, where there is one.
        high: Upper end.
    """

    value: float | str
    rows: str = ""
    low: float | None = None
    high: float | None = None


@dataclass(frozen=True)
class Evidence:
    """Tables of earlier reports, the preferred folder first.

    Attributes:
        root: Folder that the others are named from.
        folders: Folders of CSV tables below it, or patterns of them.
    """

    root: Path
    folders: Sequence[str] = ("paper/table_one/*", "paper/tables", "studies")
    _read: dict[str, pd.DataFrame] = field(default_factory=dict, repr=False)

    def line(self, table: str, column: str, **named: str) -> tuple[pd.Series, str] | None:
        """Return the line of a table with these cells and the file it stands in, None without one.

        Args:
            table: Name of the table, such as ``table2_numerical_comparison``.
            column: That the line must have a value in; a table in another folder may have it.
            **named: Cells by column that tell the line from the others.
        """
        paths = (sorted(self.root.glob(f"{folder}/{table}.csv")) for folder in self.folders)
        for path in chain.from_iterable(paths):
            name = path.relative_to(self.root).as_posix()
            rows = self._table(name)
            if not {column, *named} <= set(rows.columns):
                continue
            found = rows[(rows[list(named)] == pd.Series(named)).all(axis=1) & rows[column].notna()]
            if len(found):
                return found.iloc[0], name
        return None

    def number(self, table: str, column: str, **named: str) -> Measured | None:
        """Return one cell of a table as a number, None where it is not there or empty."""
        found = self.line(table, column, **named)
        return None if found is None else Measured(float(found[0][column]), found[1])

    def precision(self, robot: str, solver: str, metric: str) -> Measured | None:
        """Return a number of Table II with its interval, where its kind has one.

        A mean has the normal interval of its standard deviation and number of poses, a success rate
        Wilson's; standard deviations and times have none.

        Args:
            robot: Name of the robot.
            solver: Name of the solver.
            metric: Of the published numbers.
        """
        named = {"robot": robot_title(robot), "solver": solver_title(solver)}
        found = self.line("table2_numerical_comparison", metric, **named)
        if found is None:
            return None
        line, rows = found
        value, poses = float(line[metric]), int(line["poses"])
        if metric.endswith("_mean"):
            sd = float(line[metric.replace("_mean", "_sd")])
            reach = float(stats.norm.ppf((1 + CONFIDENCE) / 2)) * sd / math.sqrt(poses)
            return Measured(value, rows, value - reach, value + reach)
        if metric == "success_rate":
            rate = wilson_interval(round(value / 100 * poses), poses, CONFIDENCE)
            return Measured(value, rows, 100 * rate.low, 100 * rate.high)
        return Measured(value, rows)

    def outcome(self, robot: str, title: str) -> Measured | None:
        """Return the share of a class of grasp outcomes [%] with its interval."""
        named = {"robot": robot_title(robot), "setting": CAMERA_AND_AGENT, "outcome": title}
        found = self.line("figure5_human_in_the_loop", "share", **named)
        if found is None:
            return None
        low, value, high = (100 * float(found[0][f"share{end}"]) for end in ("_low", "", "_high"))
        return Measured(value, found[1], low, high)

    def _table(self, name: str) -> pd.DataFrame:
        if name not in self._read:
            self._read[name] = pd.read_csv(self.root / name)
        return self._read[name]
