"""Figures of the planner benchmark over all plans."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.reporting.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.reporting.published import Published
from pipeline.reporting.style import (
    INK,
    LOOKS,
    PAPER_COLOUR,
    label_first_column,
    legend_below,
    logarithmic,
    looks,
    panels,
)
from pipeline.reporting.tables_planner import PLANNER_ROBOTS, one_row_a_plan, with_paths_judged

SMALLEST_MM = 1e-4  # mm, smaller tip errors are drawn here
ALONE = "without a flip before repair"
MARGIN = 4.0  # % between the number of a part and its end
WIDEST = 0.12  # share below which a part of a bar has no room for its number


def planner_times(plans: Mapping[str, pd.DataFrame], published: Published) -> Figure:
    """Plan time and largest tip error of every plan, by solver."""
    robots = ordered_robots(plans)
    figure, axes = panels(len(robots), 3.7, 3.0)
    look = looks(solver for rows in plans.values() for solver in rows.solver)
    paper = published.number("planner", "nico_nicol", "cycleik", "time_per_50_point_plan")
    for axis, robot in zip(axes, robots, strict=True):
        rows = one_row_a_plan(plans[robot])
        for solver in ordered_solvers(rows.solver):
            mine = rows[rows.solver == solver]
            axis.plot(
                mine.plan_time_ms,
                np.maximum(mine.tip_error_mm, SMALLEST_MM),
                look[solver].marker,
                color=look[solver].colour,
                alpha=0.45,
                markeredgewidth=0,
                markersize=4.5 if len(mine) < 300 else 3.0,
                label=solver_title(solver),
            )
        if paper is not None and robot in PLANNER_ROBOTS:
            axis.axvline(paper, color=PAPER_COLOUR, linestyle="--", label="paper's plan time")
        axis.set(title=robot_title(robot), xlabel="time of a plan of 50 poses [ms]")
        logarithmic(axis, "x")
        logarithmic(axis, "y")
    label_first_column(axes, "largest tip error on the path [mm]")
    legend_below(figure, axes)
    return figure


def planner_flips(plans: Mapping[str, pd.DataFrame]) -> Figure:
    """Of the plans in reach, the shares without a flip as asked, on another curve, and with one."""
    robots = ordered_robots(plans)
    figure, axes = panels(len(robots), 3.7, 2.2)
    for axis, robot in zip(axes, robots, strict=True):
        every = with_paths_judged(one_row_a_plan(plans[robot]))
        inside = every[every.in_reach]
        _stacked(axis, inside)
        axis.set(title=f"{robot_title(robot)}: {inside.pair.nunique()} paths in reach")
        axis.set(xlim=(0, 100), xlabel="plans [%]")
        axis.grid(visible=False, axis="y")
    legend_below(figure, axes, columns=2)
    return figure


def _stacked(axis: Axes, plans: pd.DataFrame) -> None:
    """One bar a solver, the first on top, with the shares in it."""
    solvers = ordered_solvers(plans.solver)
    places = -np.arange(len(solvers), dtype=float)
    parts = {
        "without a flip, as asked": (plans.smooth & ~plans.rerouted, LOOKS[0].colour, "white"),
        "without a flip, on another curve": (plans.smooth & plans.rerouted, LOOKS[2].colour, INK),
        "with a flip or a waypoint missed": (~plans.smooth, LOOKS[1].colour, "white"),
    }
    left = np.zeros(len(solvers))
    for label, (holds, colour, ink) in parts.items():
        shares = np.array([holds[plans.solver == solver].mean() for solver in solvers])
        axis.barh(places, 100 * shares, 0.72, 100 * left, color=colour, label=label)
        for place, share, start in zip(places, shares, left, strict=True):
            if share >= WIDEST:
                end = (
                    100 * (start + share) - MARGIN
                )  # a diamond may be further left, or on the edge
                number = f"{100 * share:.1f}".removesuffix(".0")
                axis.text(end, place, number, color=ink, ha="right", va="center", fontsize=7)
        left += shares
    if "query_flips" in plans:
        alone = [(plans.query_flips[plans.solver == solver] == 0).mean() for solver in solvers]
        (marks,) = axis.plot(100 * np.array(alone), places, "D", label=ALONE, clip_on=False)
        marks.set(markerfacecolor="white", markeredgecolor=INK, markersize=5.5)
    axis.set_yticks(places, [solver_title(solver) for solver in solvers])
