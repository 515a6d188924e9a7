"""The search: how studies went, and the best of one against Table I at one budget."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import pandas as pd
from scipy import stats

from pipeline.presentation.columns import ROBOT, count, number, share, text, under
from pipeline.presentation.naming import ordered_robots, robot_title
from pipeline.presentation.table import Table
from pipeline.reporting.data import Topic
from pipeline.reporting.results import Results

CONFIDENCE = 0.95
RIVAL = "table_one"
TITLES = {"best": "best of the search", "default": "default", RIVAL: "Table I"}
CURRENCIES = {
    "seconds": "{:g} s of this machine's processor time each",
    "multiply_adds": "{:.3g} multiply-adds of training each",
    "poses": "{:,.0f} training poses seen each",
}
POSITION, ROTATION = "position_error_mm", "rotation_error_deg"


@dataclass(frozen=True)
class Study:
    """One search: its trials, and what its best trial is the best of."""

    robot: str
    trials: pd.DataFrame
    best: dict[str, Any]

    @property
    def complete(self) -> pd.DataFrame:
        """Trials that ended, the best first."""
        done = self.trials[self.trials.state == "COMPLETE"]
        return done.sort_values(["objective", "number"])

    def ended(self, *states: str) -> int:
        """Number of trials in any of these states."""
        return int(self.trials.state.isin(states).sum())

    @property
    def first(self) -> float | None:
        """Objective of the trial that the search started from."""
        done = self.complete
        starts = done[~done.drawn] if "drawn" in done else done[:0]
        return None if starts.empty else float(starts.sort_index().objective.iloc[0])

    @property
    def first_rank(self) -> int | None:
        """Place of that trial among the complete ones, from 1."""
        done = self.complete
        if "drawn" not in done or done.drawn.all():
            return None
        return 1 + [*done.index].index(min(done[~done.drawn].index))

    @property
    def by_layers(self) -> str | None:
        """Least objective of each number of hidden layers, where the search draws that."""
        done = self.complete
        if "hidden_layers" not in done:
            return None
        drawn = done.dropna(subset=["hidden_layers"])
        least = drawn.groupby(drawn.hidden_layers.astype(int)).objective.agg(["min", "size"])
        return ", ".join(
            f"{layers}: {row['min']:.3g} of {int(row['size'])}" for layers, row in least.iterrows()
        )

    def winner(self, name: str) -> Any:
        """Return a value of the best trial, None where there is none."""
        return self.complete.iloc[0].get(name)


def _winner(name: str) -> Callable[[Study], Any]:
    return lambda study: study.winner(name)


STUDIES = (
    ROBOT,
    text("model", "Model", lambda study: (study.best.get("of") or {}).get("model")),
    count("finished", "finished", lambda study: study.ended("COMPLETE", "PRUNED")),
    count("pruned", "of these cut short", lambda study: study.ended("PRUNED")),
    count("failed", "failed", lambda study: study.ended("FAIL")),
    number("objective", "best objective", _winner("objective"), 4),
    number("first", "objective of the start", digits=4),
    count("first_rank", "rank of the start"),
    text("by_layers", "best objective by hidden layers"),
    count("trial", "best trial", _winner("number")),
    number(POSITION, "position [mm]", _winner(POSITION)),
    number(ROTATION, "rotation [deg]", _winner(ROTATION)),
)


def studies(results: Results) -> Table:
    """How each search went."""
    found = [Study(robot, *results.tune[robot]) for robot in ordered_robots(results.tune)]
    known = [study for study in found if {"state", "objective"} <= set(study.trials)]
    return Table.of(
        [study for study in known if len(study.complete)],
        STUDIES,
        name="studies",
        title="Searches",
        caption="Trials of each study and its best one; errors on the validation set, Euclidean "
        "and geodesic, after the short training of a trial. The start is the trial before all "
        "drawn ones: Table I in the paper's search. By hidden layers: least objective, of how many "
        "trials.",
    )


@dataclass(frozen=True)
class Contender:
    """Trainings of one configuration, and those of Table I at the same budget."""

    robot: str
    name: str
    rows: pd.DataFrame
    rival: pd.DataFrame

    @property
    def title(self) -> str:
        """How the configuration is called, and its model."""
        return f"{TITLES.get(self.name, self.name)} ({self.rows.model.iloc[0]})"

    def mean(self, column: str) -> float:
        """Return the mean of a column over the trainings."""
        return float(self.rows[column].mean())

    def interval(self, column: str) -> tuple[float, float, float] | None:
        """Return Welch's interval of the difference to Table I, None where it says nothing."""
        if self.name == RIVAL or len(self.rows) < 2 or len(self.rival) < 2:
            return None
        return welch(self.rows[column], self.rival[column])

    def difference(self, column: str) -> str | None:
        """Return the difference to Table I with its interval, as text."""
        found = self.interval(column)
        if found is None:
            return None
        middle, low, high = found
        return f"{middle:+.3g} [{low:+.3g}, {high:+.3g}]".replace("-", "−")

    @property
    def verdict(self) -> str | None:
        """Whether it beats Table I in both errors."""
        intervals = [found for name in (POSITION, ROTATION) if (found := self.interval(name))]
        if not intervals:
            return None
        if all(high < 0 for _, _, high in intervals):
            return "beats it"
        if all(low > 0 for _, low, _ in intervals):
            return "is beaten"
        return "not shown to be better in both errors"


def _mean(column: str, per: float = 1.0) -> Callable[[Contender], float]:
    return lambda line: line.mean(column) / per


def _difference(column: str) -> Callable[[Contender], str | None]:
    return lambda line: line.difference(column)


COMPARED = (
    ROBOT,
    text("name", "Configuration", "title"),
    count("trainings", "trainings", lambda line: len(line.rows)),
    count("parameters", "parameters", lambda line: line.rows.parameters.iloc[0]),
    *under(
        "spent on each training",
        number("train_s", "processor time [s]", _mean("train_s")),
        number("multiply_adds", "multiply-adds [1e12]", _mean("multiply_adds", per=1e12)),
        count("poses_seen", "poses seen", _mean("poses_seen")),
    ),
    *under(
        "error",
        number(POSITION, "position [mm]", _mean(POSITION), 4),
        number(ROTATION, "rotation [deg]", _mean(ROTATION), 4),
    ),
    share("success_10mm_20deg", "within 10 mm, 20 deg [%]", _mean("success_10mm_20deg"), 2),
    *under(
        "difference to Table I, 95 % interval",
        text("position_difference", "position [mm]", _difference(POSITION)),
        text("rotation_difference", "rotation [deg]", _difference(ROTATION)),
    ),
    text("verdict", "against Table I"),
)


def tuned_against_table_one(results: Results) -> Table:
    """The best of a search and Table I, trained at one budget, and whether one beats the other."""
    lines, notes = [], []
    for robot in ordered_robots(results.compare_tuned):
        rows = results.compare_tuned[robot]
        rival = rows[rows["name"] == RIVAL]
        named = rows.groupby("name", sort=False)
        lines += [Contender(robot, str(name), mine, rival) for name, mine in named]
        for currency, amount in rows.groupby(["currency", "amount"]).size().index:
            budget = CURRENCIES[str(currency)].format(float(amount))
            notes.append(f"{robot_title(robot)}: equal budget is {budget}.")
    return Table.of(
        lines,
        COMPARED,
        name="tuned_against_table_one",
        title="The best of the search against Table I at equal training budget",
        caption="Means over trainings with other seeds on the same validation set, Euclidean and "
        "geodesic. The interval of the difference is Welch's t-interval over the trainings; where "
        "it holds zero, nothing is shown.",
        notes=notes,
    )


def welch(mine: pd.Series, theirs: pd.Series) -> tuple[float, float, float]:
    """Return the difference of two means and the ends of its confidence interval.

    Welch (1947), "The generalization of Student's problem when several different population
    variances are involved".
    """
    test = stats.ttest_ind(mine, theirs, equal_var=False)
    low, high = test.confidence_interval(CONFIDENCE)
    return float(mine.mean() - theirs.mean()), float(low), float(high)


TOPIC = Topic(
    stages=("tune", "compare_tuned"),
    tables=(
        lambda data: studies(data.results),
        lambda data: tuned_against_table_one(data.results),
    ),
)
