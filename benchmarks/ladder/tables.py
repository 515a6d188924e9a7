"""Tables of the ladder: its cells, what each oracle gains, and who owns what is lost."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import pandas as pd

from benchmarks.ladder.cells import Cell
from benchmarks.ladder.owners import OWNERS, UNDECIDED, Gain, gains
from pipeline.presentation.columns import (
    ROBOT,
    SOLVER,
    Column,
    count,
    number,
    p_value,
    plain,
    share,
    text,
    under,
)
from pipeline.presentation.naming import OUTCOMES, solver_title
from pipeline.presentation.table import Table
from pipeline.reporting.topics.agent import setting_title
from pipeline.reporting.topics.outcomes import SUCCESS_COLUMNS, Counted

CONFIDENCE = 0.95  # of the Wilson intervals


@dataclass(frozen=True, kw_only=True)
class Line(Counted):
    """A cell with its trials."""

    cell: Cell

    def owned(self, owner: str) -> int:
        """How many lost trials somebody owns."""
        assert self.rows is not None
        return int((self.rows["owner"] == owner).sum())

    def median(self, column: str) -> float:
        """Median of a column of the raw rows, where it has a value."""
        assert self.rows is not None
        return float(self.rows[column].median())


def lines(rows: pd.DataFrame) -> list[Line]:
    """Return the cells in the order of the rows.

    Args:
        rows: Raw rows with their owners.
    """
    parts = rows.groupby(["robot", "perception", "agent", "solver"], sort=False)
    return [
        Line(str(key[0]), "success", part, CONFIDENCE, cell=Cell(*map(str, key)))
        for key, part in parts
    ]


def _of_cell(column: Column, part: str) -> Column:
    """A column that shows a part of a line's cell."""
    return replace(column, source=lambda line: getattr(line.cell, part))


SETTING = text(
    "setting",
    "perception / agent",
    lambda line: setting_title(f"{line.cell.perception}-{line.cell.agent}"),
)
WHICH = (_of_cell(ROBOT, "robot"), SETTING, _of_cell(SOLVER, "solver"))
CLASSES = {key: title for key, title in OUTCOMES.items() if key != "success"}


def _ended(key: str) -> Column:
    return count(key, CLASSES[key], lambda line: line.ended(key))


def _owned(owner: str) -> Column:
    return count(owner, owner, lambda line: line.owned(owner))


def tables(rows: pd.DataFrame) -> Iterator[Table]:
    """Yield the tables of the study.

    Args:
        rows: Raw rows with their owners.
    """
    found = lines(rows)
    yield Table.of(
        found,
        (
            *WHICH,
            *SUCCESS_COLUMNS,
            *under("lost", *map(_ended, CLASSES)),
            number(
                "sighting_mm", "place error [mm]", lambda line: line.median("sighting_error_mm")
            ),
            number("trial_s", "s a trial", lambda line: line.median("wall_s")),
        ),
        name="ladder_cells",
        title="Cells",
        caption="The same pinned initial states in every cell. Success with 95 % Wilson intervals, "
        "lost trials by class; medians of the error of the believed place and of the time.",
    )
    yield Table.of(
        found,
        (
            *WHICH,
            count("trials", "trials"),
            count("lost", "lost", lambda line: line.trials - line.ended("success")),
            *under("owned by", *(_owned(owner) for owner in OWNERS if owner != UNDECIDED)),
            _owned(UNDECIDED),
        ),
        name="ladder_owners",
        title="Owners of lost trials",
        caption="The first oracle that makes the same initial state succeed, in the place of that "
        "part alone: the calibrated eye (calibration), true places (perception), the policy "
        "(agent), refined CycleIK (solver). Several: only all of them together do. Physics: lost "
        "with all of them, so grasp and physics own it. Undecided: a cell that would tell has not "
        "run the trial.",
    )
    yield _gains(gains(rows))
    yield _lost(rows, found[0].cell)


def _gains(found: list[Gain]) -> Table:
    return Table.of(
        found,
        (
            *WHICH,
            text("oracle", "oracle of", "owner"),
            count("trials", "trials"),
            count("won", "won"),
            count("lost", "lost"),
            share("effect", "gain [%]", lambda gain: gain.test.effect, signed=True),
            p_value("p", lambda gain: gain.test.p_value),
            replace(p_value("p_holm", "adjusted"), title="p (Holm)"),
        ),
        name="ladder_gains",
        title="What each oracle gains",
        caption="A cell against the one with one oracle more, on the trials that both have: those "
        "that only the oracle won and that only it lost, the difference of the rates, and "
        "McNemar's exact test, whose p-value is adjusted for all comparisons of the robot too.",
    )


def _lost(rows: pd.DataFrame, first: Cell) -> Table:
    """The lost trials of the first cell, of all robots."""
    own = rows[["perception", "agent", "solver"]] == [first.perception, first.agent, first.solver]
    return Table.of(
        rows[own.all(axis=1) & (rows["owner"] != "")],
        (
            ROBOT,
            count("trial", "trial"),
            text("object", "object", convert=plain),
            text("class", "Outcome"),
            text("reason", "reason"),
            text("owner", "owner"),
        ),
        name="ladder_lost",
        title="Lost trials",
        caption=f"Every lost trial of: {setting_title(f'{first.perception}-{first.agent}')}, "
        f"{solver_title(first.solver)}. Those of the other cells are in the CSV.",
    )
