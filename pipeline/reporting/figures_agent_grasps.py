"""Figure of the trials with a camera or an agent: the paper's figure 5 and what ours is made of."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pipeline.evaluation.statistics import wilson_interval
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import OUTCOMES, ordered_robots, outcome_key, robot_title
from pipeline.reporting.published import Published
from pipeline.reporting.style import INK, LOOKS, SOFT, label_first_column, legend_below, panels
from pipeline.reporting.tables_trials import PUBLISHED_TRIALS

Array = NDArray[np.float64]
WIDTH = 0.84  # of all bars of an outcome together, of the room that it has


def agent_outcomes(
    trials: Mapping[str, Mapping[str, pd.DataFrame]], published: Published, config: ReportConfig
) -> Figure:
    """The five classes by robot: the paper, and each of our settings with Wilson intervals.

    Args:
        trials: Raw rows by robot and by how the setting is called.
        published: The paper's counts.
        config: Confidence of the intervals.
    """
    robots = ordered_robots(trials)
    settings = list(dict.fromkeys(name for robot in robots for name in trials[robot]))
    figure, axes = panels(len(robots), 4.2, 2.9, columns=2)
    places = np.arange(len(OUTCOMES), dtype=float)
    width = WIDTH / (len(settings) + 1)
    for axis, robot in zip(axes, robots, strict=True):
        counts = [published.number("grasping", robot, "cycleik", key) for key in OUTCOMES]
        first = places - 0.5 * WIDTH + 0.5 * width
        if any(count is not None for count in counts):
            shares = np.array([100 * (count or 0) / PUBLISHED_TRIALS for count in counts])
            axis.bar(first, shares, 0.94 * width, color="white", edgecolor=SOFT, hatch="////",
                     label="paper (hardware)")  # fmt: skip
            _write(axis, first, shares, shares)
        for k, setting in enumerate(settings):
            if setting not in trials[robot]:
                continue
            keys = trials[robot][setting]["class"].map(outcome_key)
            found = [
                wilson_interval(int((keys == key).sum()), len(keys), config.confidence)
                for key in OUTCOMES
            ]
            bars = 100 * np.array([[each.estimate, each.low, each.high] for each in found])
            reach = np.clip([bars[:, 0] - bars[:, 1], bars[:, 2] - bars[:, 0]], 0, None)
            at = first + (k + 1) * width
            axis.bar(at, bars[:, 0], 0.94 * width, color=LOOKS[k].colour, yerr=reach, capsize=2,
                     error_kw={"elinewidth": 0.9, "ecolor": SOFT}, label=setting)  # fmt: skip
            _write(axis, at, bars[:, 0], bars[:, 2])
        axis.set_xticks(places, [title.replace(" ", "\n") for title in OUTCOMES.values()])
        axis.set(ylim=(0, 112), title=robot_title(robot))
        axis.grid(visible=False, axis="x")
    label_first_column(axes, "trials [%]")
    legend_below(figure, axes)
    return figure


def _write(axis: Axes, places: Array, shares: Array, tops: Array) -> None:
    """Write the share over each bar."""
    for place, share, top in zip(places, shares, tops, strict=True):
        axis.text(place, top + 1.5, f"{share:.0f}", ha="center", va="bottom", size=7, color=INK)
