"""Figures of grasp trials beyond the paper's: where they succeeded, and what that depends on."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import OUTCOMES, ordered_robots, robot_title, solver_title
from pipeline.reporting.style import (
    LOOKS,
    SOFT,
    label_first_column,
    legend_below,
    panels,
)
from pipeline.reporting.table import Cell
from pipeline.reporting.tables_grasps import AXES, study_axes, success_cells

CLASSES = tuple(OUTCOMES.values())
COLOURS = ("#0b3c5d", "#e69f00", "#d55e00", "#cc79a7", "#6b4c9a")  # a class each, as in CLASSES
Studies = Mapping[tuple[str, str], pd.DataFrame]


def grasp_places(grasps: Mapping[str, pd.DataFrame], config: ReportConfig) -> Figure:
    """Every trial where its object lay, and the share of success by object."""
    robots = ordered_robots(grasps)
    figure, axes = panels(2 * len(robots), 4.2, 2.6, columns=2)
    for k, robot in enumerate(robots):
        trials, (plane, bars) = grasps[robot], axes[2 * k : 2 * k + 2]
        for name, colour in zip(CLASSES, COLOURS, strict=True):
            part = trials[trials["class"] == name]
            if len(part):
                marker = "o" if name == CLASSES[0] else "X"
                plane.plot(part["y_m"], part["x_m"], marker, color=colour, label=name)
        plane.invert_xaxis()  # the robot looks up: its left is on the left
        plane.set(title=robot_title(robot), xlabel="y [m]", ylabel="x, away from the robot [m]")
        _by_object(bars, trials, config)
    legend_below(figure, axes)
    return figure


def grasp_studies(studies: Studies, config: ReportConfig) -> Figure:
    """Success of the variants of each study: points for one setting, a map for two."""
    keys = sorted(studies, key=lambda key: (key[1], key[0]))
    figure, axes = panels(len(keys), 3.6, 2.9)
    for axis, (robot, study) in zip(axes, keys, strict=True):
        rows = studies[robot, study]
        varied = study_axes(rows)
        if len(varied) == 2:
            _map(axis, rows, varied)
        else:
            _points(axis, rows, varied[0], config)
        axis.set_title(f"{robot_title(robot)}: {study.replace('_', ' ')}")
    label_first_column([axis for axis in axes if not axis.images], "success [%]")
    return figure


def _by_object(axis: Axes, trials: pd.DataFrame, config: ReportConfig) -> None:
    names = list(dict.fromkeys(trials["object"].sort_values()))
    cells = [success_cells(trials[trials["object"] == name], config) for name in names]
    _whiskers(axis, np.arange(len(names), dtype=float), cells)
    axis.set_xticks(range(len(names)), [name.replace("_", "\n") for name in names])
    axis.set(ylim=(0, 104), xlim=(-0.5, len(names) - 0.5), ylabel="success [%]")


def _points(axis: Axes, rows: pd.DataFrame, varied: str, config: ReportConfig) -> None:
    column, label = AXES[varied]
    values = list(dict.fromkeys(rows[column]))
    cells = [success_cells(rows[rows[column] == value], config) for value in values]
    if varied == "solver":
        places = np.arange(len(values), dtype=float)
        names = [solver_title(str(value)).replace(" ", "\n") for value in values]
        axis.set_xticks(places, names)
        axis.set_xlim(-0.5, len(values) - 0.5)
    else:
        places = np.array(values, dtype=np.float64)
        axis.set_xlabel(label)
    _whiskers(axis, places, cells)
    axis.set_ylim(0, 104)


def _whiskers(axis: Axes, places: np.ndarray, cells: list[dict[str, Cell]]) -> None:
    """Shares with their Wilson intervals."""
    names = ("share", "share_low", "share_high")
    shares = 100.0 * np.array([[cell[name] for name in names] for cell in cells], dtype=np.float64)
    reach = np.clip([shares[:, 0] - shares[:, 1], shares[:, 2] - shares[:, 0]], 0.0, None)
    axis.errorbar(places, shares[:, 0], yerr=reach, fmt="o", color=LOOKS[0].colour, ecolor=SOFT,
                  capsize=3, markersize=5)  # fmt: skip


def _map(axis: Axes, rows: pd.DataFrame, varied: list[str]) -> None:
    """Share of success for every pair of values, written into its field."""
    columns = [AXES[name][0] for name in varied]
    shares = rows.assign(success=100.0 * (rows["class"] == CLASSES[0])).pivot_table(
        index=columns[0], columns=columns[1], values="success", aggfunc="mean"
    )
    axis.imshow(shares.to_numpy(), vmin=0, vmax=100, cmap="cividis", aspect="auto", origin="lower")
    for (i, j), share in np.ndenumerate(shares.to_numpy()):
        colour = "white" if share < 60 else "black"
        axis.text(j, i, f"{share:.0f}", ha="center", va="center", color=colour, size=8)
    axis.set_yticks(range(len(shares.index)), [f"{value:g}" for value in shares.index])
    axis.set_xticks(range(len(shares.columns)), [f"{value:g}" for value in shares.columns])
    axis.set(ylabel=AXES[varied[0]][1], xlabel=AXES[varied[1]][1])
    axis.grid(visible=False)
