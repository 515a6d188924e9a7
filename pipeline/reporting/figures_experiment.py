"""Figures of training and grasping."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.evaluation.statistics import wilson_interval
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import (
    OUTCOMES,
    ordered_robots,
    outcome_key,
    robot_title,
)
from pipeline.reporting.published import Published
from pipeline.reporting.style import (
    INK,
    SOFT,
    label_first_column,
    legend_below,
    logarithmic,
    looks,
    panels,
)
from pipeline.reporting.tables_trials import PUBLISHED_TRIALS

Curves = Mapping[tuple[str, str], tuple[dict[str, Any], pd.DataFrame]]
SMOOTHING = 25  # points of a moving median over the noisy batch errors


def training_curves(trained: Curves) -> Figure:
    """Errors on the validation set and on the batches while each network was trained."""
    drawn = {key: curve for key, (_, curve) in trained.items() if len(curve)}
    robots = ordered_robots(robot for robot, _ in drawn)
    look = looks(model for _, model in drawn)
    kinds = (("position_error_mm", "position [mm]"), ("rotation_error_deg", "rotation [deg]"))
    figure, axes = panels(len(robots) * len(kinds), 3.7, 2.3, columns=len(kinds))
    places = [(robot, kind) for robot in robots for kind in kinds]
    for axis, (robot, (column, label)) in zip(axes, places, strict=True):
        for (name, model), curve in drawn.items():
            if name == robot:
                _curve(axis, curve, column, look[model].colour, model)
        axis.set(ylabel=label, xlabel="poses seen [million]", title=robot_title(robot))
        logarithmic(axis, "y")
    legend_below(figure, axes)
    return figure


def grasp_outcomes(
    grasps: Mapping[str, pd.DataFrame], published: Published, config: ReportConfig
) -> Figure:
    """Figure 5 of the paper: outcomes of the trials, published beside this run's."""
    robots = ordered_robots([*grasps, *published.robots("grasping")])
    figure, axes = panels(len(robots), 3.1, 2.9)
    for axis, robot in zip(axes, robots, strict=True):
        places = np.arange(len(OUTCOMES))
        paper = [published.number("grasping", robot, "cycleik", key) for key in OUTCOMES]
        if any(count is not None for count in paper):
            shares = [100 * (count or 0) / PUBLISHED_TRIALS for count in paper]
            axis.bar(
                places - 0.2,
                shares,
                0.38,
                color="white",
                edgecolor=SOFT,
                hatch="////",
                label="paper (hardware)",
            )
            _bar_labels(axis, places - 0.2, shares, shares)
        if robot in grasps:
            _own_bars(axis, places + 0.2, grasps[robot], config)
        axis.set_xticks(places, [title.replace(" ", "\n") for title in OUTCOMES.values()])
        axis.set(ylim=(0, 112), title=robot_title(robot))
        axis.grid(visible=False, axis="x")
    label_first_column(axes, "trials [%]")
    legend_below(figure, axes)
    return figure


def _curve(axis: Axes, curve: pd.DataFrame, column: str, colour: str, model: str) -> None:
    millions = curve["samples"] / 1e6
    if column in curve:
        smooth = curve[column].rolling(SMOOTHING, min_periods=1, center=True).median()
        axis.plot(millions, smooth, color=colour, alpha=0.35, label=f"{model}, batches")
    validation = f"validation_{column}"
    if validation in curve:
        kept = curve[validation].notna()
        axis.plot(
            millions[kept],
            curve[validation][kept],
            "o-",
            color=colour,
            markersize=3.5,
            label=f"{model}, validation",
        )


def _own_bars(axis: Axes, places: Any, trials: pd.DataFrame, config: ReportConfig) -> None:
    keys = trials["class"].map(outcome_key)
    intervals = [
        wilson_interval(int((keys == key).sum()), len(trials), config.confidence)
        for key in OUTCOMES
    ]
    shares = np.array([100 * interval.estimate for interval in intervals])
    low = np.array([100 * interval.low for interval in intervals])
    high = np.array([100 * interval.high for interval in intervals])
    reach = np.clip(np.stack([shares - low, high - shares]), 0, None)
    axis.bar(
        places,
        shares,
        0.38,
        color="#0b3c5d",
        yerr=reach,
        capsize=2,
        error_kw={"elinewidth": 0.9, "ecolor": SOFT},
        label="this run (simulation)",
    )
    _bar_labels(axis, places, shares, high)


def _bar_labels(axis: Axes, places: Any, shares: Any, tops: Any) -> None:
    for place, share, top in zip(places, shares, tops, strict=True):
        axis.text(place, top + 1.5, f"{share:.0f}", ha="center", va="bottom", size=7, color=INK)
