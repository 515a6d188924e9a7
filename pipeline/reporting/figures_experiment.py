"""Figures of training and grasping."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.figures_agent_grasps import agent_outcomes
from pipeline.reporting.naming import (
    ordered_robots,
    robot_title,
)
from pipeline.reporting.published import Published
from pipeline.reporting.style import (
    legend_below,
    logarithmic,
    looks,
    panels,
)

Curves = Mapping[tuple[str, str], tuple[dict[str, Any], pd.DataFrame]]
SMOOTHING = 25  # points of a moving median over the noisy batch errors
OURS = "this run (simulation)"


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
    ours = {robot: {OURS: grasps[robot]} if robot in grasps else {} for robot in robots}
    return agent_outcomes(ours, published, config)


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
