"""Figure 5 of the paper: what became of grasp trials, this run beside the paper."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pipeline.evaluation.statistics import Interval, wilson_interval
from pipeline.presentation.columns import ROBOT, count, share, text, under
from pipeline.presentation.naming import OUTCOMES, ordered_robots, outcome_key
from pipeline.presentation.published import Published
from pipeline.presentation.style import INK, LOOKS, SOFT, legend_below, robot_panels
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.results import Results

Array = NDArray[np.float64]
Trials = Mapping[str, Mapping[str, pd.DataFrame]]  # raw rows by robot and by setting
PUBLISHED_TRIALS = 100
OURS = "this run (simulation)"
WIDTH = 0.84  # of all bars of an outcome together, of the room that it has


@dataclass(frozen=True)
class Counted:
    """How many trials ended in one class, beside the paper's.

    Attributes:
        robot: Name of the robot.
        key: Of `naming.OUTCOMES`.
        rows: Raw rows; None where there are none.
        confidence: Of the interval.
        published: The paper's counts; None where they are not shown.
        of: What sets these trials apart: a setting, an object, a variant.
        by: What kind of thing that is.
    """

    robot: str
    key: str
    rows: pd.DataFrame | None
    confidence: float
    published: Published | None = None
    of: str = ""
    by: str = ""

    @property
    def outcome(self) -> str:
        """Class as it is written."""
        return OUTCOMES[self.key]

    @property
    def trials(self) -> int | None:
        """Number of trials."""
        return None if self.rows is None else len(self.rows)

    @cached_property
    def keys(self) -> pd.Series:
        """Class of every trial."""
        return pd.Series(dtype=str) if self.rows is None else self.rows["class"].map(outcome_key)

    def ended(self, key: str) -> int | None:
        """Return how many trials ended in a class."""
        return None if self.rows is None else int((self.keys == key).sum())

    @property
    def interval(self) -> Interval | None:
        """Share of the class with its Wilson interval."""
        if self.rows is None:
            return None
        return wilson_interval(int((self.keys == self.key).sum()), len(self.rows), self.confidence)

    @property
    def paper(self) -> float | None:
        """The paper's share."""
        if self.published is None:
            return None
        counted = self.published.number("grasping", self.robot, "cycleik", self.key)
        return None if counted is None else counted / PUBLISHED_TRIALS

    @property
    def difference(self) -> float | None:
        """Our share minus the paper's."""
        ours, paper = self.interval, self.paper
        return None if ours is None or paper is None else ours.estimate - paper


def _bound(name: str) -> Callable[[Counted], float | None]:
    return lambda line: None if line.interval is None else getattr(line.interval, name)


SHARE = (
    share("share", "ours", _bound("estimate")),
    share("share_low", "from", _bound("low")),
    share("share_high", "to", _bound("high")),
)
TRIALS = count("trials", "trials")
COUNT = count("count", "count", lambda line: line.ended(line.key))
OUTCOME_COLUMNS = (
    text("outcome", "Outcome"),
    TRIALS,
    COUNT,
    *under("share [%]", *SHARE, share("share_paper", "paper", "paper", 0)),
)
DIFFERENCE = under("share [%]", share("share_difference", "Δ", "difference", signed=True))
SUCCESS_COLUMNS = (
    TRIALS,
    replace(COUNT, title="successes"),
    *under("success [%]", replace(SHARE[0], title="share"), *SHARE[1:]),
)


def grasping(results: Results, published: Published, config: ReportConfig) -> Table:
    """Figure 5 as a table: the share of each outcome, this run in simulation beside the paper."""
    return Table.of(
        [
            Counted(robot, key, results.grasp.get(robot), config.confidence, published)
            for robot in ordered_robots([*results.grasp, *published.robots("grasping")])
            for key in OUTCOMES
        ],
        (ROBOT, *OUTCOME_COLUMNS, *DIFFERENCE),
        name="figure5_grasping",
        title="Figure 5: outcomes of grasp trials",
        caption=f"Share of trials by outcome with {config.confidence * 100:g} % Wilson intervals. "
        "This run is physics simulation; the paper's 100 trials a robot are on hardware, with its "
        "detector and language model.",
    )


def outcome_bars(trials: Trials, published: Published, config: ReportConfig) -> Figure:
    """The five classes by robot: the paper, and each of our settings with Wilson intervals.

    Args:
        trials: Raw rows by robot and by how the setting is called.
        published: The paper's counts.
        config: Confidence of the intervals.
    """
    figure, axes = robot_panels(trials, 4.2, 2.9, columns=2)
    settings = list(dict.fromkeys(name for robot in axes for name in trials[robot]))
    places = np.arange(len(OUTCOMES), dtype=float)
    width = WIDTH / (len(settings) + 1)
    first = places - 0.5 * WIDTH + 0.5 * width
    for robot, axis in axes.items():
        if robot in published.robots("grasping"):
            counts = [published.number("grasping", robot, "cycleik", key) for key in OUTCOMES]
            shares = np.array([100 * (counted or 0) / PUBLISHED_TRIALS for counted in counts])
            axis.bar(first, shares, 0.94 * width, color="white", edgecolor=SOFT, hatch="////",
                     label="paper (hardware)")  # fmt: skip
            _write(axis, first, shares, shares)
        for k, setting in enumerate(settings):
            if setting not in trials[robot]:
                continue
            rows = trials[robot][setting]
            bars, reach = intervals(
                Counted(robot, key, rows, config.confidence) for key in OUTCOMES
            )
            at = first + (k + 1) * width
            axis.bar(at, bars, 0.94 * width, color=LOOKS[k].colour, yerr=reach, capsize=2,
                     error_kw={"elinewidth": 0.9, "ecolor": SOFT}, label=setting)  # fmt: skip
            _write(axis, at, bars, bars + reach[1])
        axis.set_xticks(places, [title.replace(" ", "\n") for title in OUTCOMES.values()])
        axis.set_ylim(0, 112)
        axis.grid(visible=False, axis="x")
    legend_below(figure, axes.values(), label="trials [%]")
    return figure


def grasp_outcomes(
    grasps: Mapping[str, pd.DataFrame], published: Published, config: ReportConfig
) -> Figure:
    """Figure 5 of the paper: outcomes of the trials, published beside this run's."""
    robots = ordered_robots([*grasps, *published.robots("grasping")])
    ours = {robot: {OURS: grasps[robot]} if robot in grasps else {} for robot in robots}
    return outcome_bars(ours, published, config)


def intervals(counted: Iterable[Counted]) -> tuple[Array, Array]:
    """Shares (N,) and how far their intervals reach down and up (2, N), all in per cent."""
    found = [each.interval for each in counted]
    values = 100.0 * np.array([[i.estimate, i.low, i.high] for i in found if i is not None])
    reach = np.clip([values[:, 0] - values[:, 1], values[:, 2] - values[:, 0]], 0.0, None)
    return values[:, 0], reach


def _write(axis: Axes, places: Array, shares: Array, tops: Array) -> None:
    """Write the share over each bar."""
    for place, height, top in zip(places, shares, tops, strict=True):
        axis.text(place, top + 1.5, f"{height:.0f}", ha="center", va="bottom", size=7, color=INK)


TOPIC = Topic(
    stages=("grasp", "grasp_agent"),
    tables=(lambda data: grasping(data.results, data.published, data.config),),
    plots=(
        Plot(
            "grasp_outcomes",
            "Figure 5 of the paper: outcomes of grasp trials, with Wilson intervals. The paper's "
            "trials ran on hardware, with detector and language model.",
            lambda data: data.results.grasp,
            lambda data: grasp_outcomes(data.results.grasp, data.published, data.config),
        ),
    ),
)
