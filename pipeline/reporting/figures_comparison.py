"""Figures that set solvers, and poses, beside each other: the paper, wins, the workspace."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pipeline.evaluation.config import solver_of_rows
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.figures_benchmark import FLOOR_MM, Rows, counted
from pipeline.reporting.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.reporting.published import Published
from pipeline.reporting.style import (
    INK,
    PAPER_COLOUR,
    label_first_column,
    legend_below,
    logarithmic,
    panels,
)


def against_the_paper(summary: pd.DataFrame, published: Published) -> Figure:
    """This run beside the paper on the numbers of Table II, solver by solver."""
    lines = [
        (robot, solver)
        for robot in ordered_robots(summary.robot)
        for solver in ordered_solvers(summary[summary.robot == robot].solver)
        if published.number("numerical_comparison", robot, solver_of_rows(solver), "success_rate")
        is not None
    ]
    figure, axes = panels(3, 3.1, 0.9 + 0.32 * max(len(lines), 2))
    kinds = (
        ("position_error_mean", "paper_position_error_mm_mean", 1.0, "mean position error [mm]"),
        ("rotation_error_mean", "paper_rotation_error_deg_mean", 1.0, "mean rotation error [deg]"),
        ("success_rate", "success_paper", 100.0, "success [%]"),
    )
    for axis, (metric, column, factor, label) in zip(axes, kinds, strict=True):
        for place, (robot, solver) in enumerate(lines):
            wanted = (summary.robot == robot) & (summary.solver == solver) & summary.main
            ours = float(summary[wanted][column].iloc[0]) * factor
            paper = (
                published.number("numerical_comparison", robot, solver_of_rows(solver), metric)
                or np.nan
            )
            axis.plot([paper, ours], [place, place], color=PAPER_COLOUR, linewidth=1.2, zorder=1)
            axis.plot(paper, place, "o", color="white", markeredgecolor=INK, label="paper")
            axis.plot(ours, place, "o", color=INK, label="this run")
        names = [f"{robot_title(r)}, {solver_title(s)}" for r, s in lines]
        axis.set_yticks(range(len(lines)), names if axis is axes[0] else [""] * len(lines))
        axis.set(xlabel=label, ylim=(len(lines) - 0.5, -0.5))
        if metric != "success_rate":
            logarithmic(axis, "x")
    legend_below(figure, axes)
    return figure


def win_matrix(pairs: pd.DataFrame) -> Figure:
    """Share of poses on which the solver of the row is nearer than that of the column."""
    robots = ordered_robots(pairs.robot)
    most = max(len(_compared(pairs[pairs.robot == robot])) for robot in robots)
    size = (max(0.5 * most + 1.5, 3.0), 0.4 * most + 1.2)
    figure, axes = panels(len(robots), *size, columns=2 if most > 6 else 3)
    for axis, robot in zip(axes, robots, strict=True):
        mine = pairs[pairs.robot == robot]
        solvers = _compared(mine)
        share = np.full((len(solvers), len(solvers)), np.nan)
        for _, pair in mine.iterrows():
            i, j = solvers.index(pair["first"]), solvers.index(pair["second"])
            share[i, j], share[j, i] = pair.first_nearer, pair.second_nearer
        axis.imshow(share, cmap="Greys", vmin=0, vmax=1.25)
        for i, j in zip(*np.nonzero(~np.isnan(share)), strict=True):
            colour = "white" if share[i, j] > 0.62 else INK
            axis.text(j, i, f"{share[i, j] * 100:.0f}", ha="center", va="center", color=colour)
        names = [solver_title(name) for name in solvers]
        axis.set_xticks(range(len(names)), names, rotation=35, ha="right")
        axis.set_yticks(range(len(names)), names)
        axis.set_title(robot_title(robot))
        axis.grid(visible=False)
    return figure


def workspace_map(rows: Rows, solver: str, config: ReportConfig) -> Figure:
    """Median position error over the workspace, seen from the side: distance from the axis, z."""
    robots = ordered_robots(robot for robot, name in rows if name == solver)
    figure, axes = panels(len(robots), 3.7, 3.1)
    for axis, robot in zip(axes, robots, strict=True):
        mine = counted(rows[robot, solver], config).dropna(subset=["position_error_mm"])
        radius = np.hypot(mine.target_x_m.to_numpy(), mine.target_y_m.to_numpy())
        height = mine.target_z_m.to_numpy()
        shown = axis.hexbin(
            radius,
            height,
            C=np.maximum(mine.position_error_mm, FLOOR_MM),
            reduce_C_function=np.median,
            gridsize=_hexagons(radius, height),
            bins="log",
            cmap="cividis_r",
            linewidths=0.2,
        )
        axis.set(xlabel="distance from the base axis [m]", title=robot_title(robot))
        axis.set_aspect("equal")
        bar = figure.colorbar(shown, ax=axis, fraction=0.05)
        bar.set_label("median position error [mm]")
        logarithmic(bar.ax, "y")
    label_first_column(axes, "height [m]")
    return figure


def _paper(published: Published, robot: str, solver: str, metric: str) -> float | None:
    """The paper's number; it has one TRAC-IK, whether ours was pinned or not."""
    return published.number("numerical_comparison", robot, solver_of_rows(solver), metric)


def _hexagons(radius: NDArray[np.float64], height: NDArray[np.float64]) -> tuple[int, int]:
    """Hexagons side by side and on top of each other: regular ones, of about 16 poses each."""
    width, tall = max(float(np.ptp(radius)), 1e-6), max(float(np.ptp(height)), 1e-6)
    across = max(int(np.sqrt(len(radius) / 16 * width / tall)), 4)
    return across, max(int(across * tall / width / np.sqrt(3)), 2)


def _compared(pairs: pd.DataFrame) -> list[str]:
    return ordered_solvers([*pairs["first"], *pairs["second"]])
