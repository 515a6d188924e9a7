"""Figures of the solver benchmark, each a pure function of rows or of their summary."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.reporting.published import Published
from pipeline.reporting.style import (
    INK,
    PAPER_COLOUR,
    SOFT,
    Look,
    label_first_column,
    legend_below,
    logarithmic,
    looks,
    panels,
)
from pipeline.reporting.summary import apply_not_found, main_batch

Rows = Mapping[tuple[str, str], pd.DataFrame]
TOLERANCES = np.geomspace(1e-2, 3e2, 241)  # mm and deg at once
FLOOR_MM, FLOOR_DEG = 1e-4, 1e-5  # errors below are drawn here: the axes are logarithmic


def success_against_tolerance(rows: Rows, config: ReportConfig) -> Figure:
    """Share of poses within x mm and x deg, for all x: one tolerance is one vertical line."""
    robots = ordered_robots(robot for robot, _ in rows)
    look = looks(solver for _, solver in rows)
    figure, axes = panels(len(robots), 3.7, 3.0)
    for axis, robot in zip(axes, robots, strict=True):
        for solver in _of(rows, robot):
            counted = _counted(rows[robot, solver], config)
            worse = np.maximum(
                counted.position_error_mm.to_numpy(), counted.rotation_error_deg.to_numpy()
            )
            reached = worse[counted.within_limits.to_numpy(dtype=bool) & ~np.isnan(worse)]
            share = np.searchsorted(np.sort(reached), TOLERANCES, side="left") / len(counted)
            axis.plot(
                TOLERANCES,
                share * 100,
                color=look[solver].colour,
                linestyle=look[solver].line,
                marker=look[solver].marker,
                markevery=(look_offset(solver, look), 40),
                label=solver_title(solver),
            )
        axis.axvline(1.0, color=SOFT, linewidth=0.8, zorder=0)
        axis.set(ylim=(-2, 102), title=robot_title(robot), xlabel="tolerance [mm and deg]")
        logarithmic(axis, "x")
    label_first_column(axes, "poses within [%]")
    legend_below(figure, axes)
    return figure


def error_against_time(summary: pd.DataFrame, published: Published) -> Figure:
    """Mean error against time per pose, batch sizes apart, with the Pareto front."""
    robots = ordered_robots(summary.robot)
    look = looks(summary.solver)
    figure, axes = panels(len(robots), 3.7, 3.3)
    for axis, robot in zip(axes, robots, strict=True):
        mine = summary[summary.robot == robot]
        _front(axis, mine)
        for solver in ordered_solvers(mine.solver):
            _points(axis, mine[mine.solver == solver], look[solver], solver_title(solver))
        _published_points(axis, published, robot)
        axis.set(title=robot_title(robot), xlabel="time per pose [µs]")
        logarithmic(axis, "x")
        logarithmic(axis, "y")
    label_first_column(axes, "mean error over the axes [mm]")
    legend_below(figure, axes)
    return figure


def error_distributions(rows: Rows, config: ReportConfig) -> Figure:
    """Median, middle half and 1st to 99th percentile of both errors, one line a solver."""
    robots = ordered_robots(robot for robot, _ in rows)
    look = looks(solver for _, solver in rows)
    most = max(len(_of(rows, robot)) for robot in robots)
    kinds = (
        ("position_error_mm", "position error [mm]", FLOOR_MM),
        ("rotation_error_deg", "rotation error [deg]", FLOOR_DEG),
    )
    figure, axes = panels(len(robots) * len(kinds), 3.7, 0.9 + 0.26 * most, columns=len(kinds))
    places = [(robot, kind) for robot in robots for kind in kinds]
    for axis, (robot, (column, label, floor)) in zip(axes, places, strict=True):
        solvers = _of(rows, robot)
        for place, solver in enumerate(solvers):
            values = _counted(rows[robot, solver], config)[column].dropna().to_numpy()
            _spread(axis, place, np.maximum(values, floor), look[solver])
        names = [solver_title(name) for name in solvers]
        axis.set_yticks(range(len(names)), names if column == kinds[0][0] else [""] * len(names))
        axis.set(xlabel=label, ylim=(len(solvers) - 0.5, -0.5), title=robot_title(robot))
        logarithmic(axis, "x")
        axis.grid(visible=False, axis="y")
    return figure


def against_the_paper(summary: pd.DataFrame, published: Published) -> Figure:
    """This run beside the paper on the numbers of Table II, solver by solver."""
    lines = [
        (robot, solver)
        for robot in ordered_robots(summary.robot)
        for solver in ordered_solvers(summary[summary.robot == robot].solver)
        if published.number("numerical_comparison", robot, solver, "success_rate") is not None
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
            paper = published.number("numerical_comparison", robot, solver, metric) or np.nan
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
        counted = _counted(rows[robot, solver], config).dropna(subset=["position_error_mm"])
        radius = np.hypot(counted.target_x_m.to_numpy(), counted.target_y_m.to_numpy())
        height = counted.target_z_m.to_numpy()
        shown = axis.hexbin(
            radius,
            height,
            C=np.maximum(counted.position_error_mm, FLOOR_MM),
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


def look_offset(solver: str, look: Mapping[str, Look]) -> int:
    """Start markers of each line elsewhere, so that lines on top of each other show."""
    return list(look).index(solver) * 7 % 40


def _hexagons(radius: NDArray[np.float64], height: NDArray[np.float64]) -> tuple[int, int]:
    """Hexagons side by side and on top of each other: regular ones, of about 16 poses each."""
    width, tall = max(float(np.ptp(radius)), 1e-6), max(float(np.ptp(height)), 1e-6)
    across = max(int(np.sqrt(len(radius) / 16 * width / tall)), 4)
    return across, max(int(across * tall / width / np.sqrt(3)), 2)


def _of(rows: Rows, robot: str) -> list[str]:
    return ordered_solvers(solver for name, solver in rows if name == robot)


def _compared(pairs: pd.DataFrame) -> list[str]:
    return ordered_solvers([*pairs["first"], *pairs["second"]])


def _counted(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    main = rows[rows.batch_size == main_batch(rows)]
    return apply_not_found(main, config.not_found)


def _spread(axis: Axes, place: int, values: NDArray[np.float64], look: Look) -> None:
    if values.size == 0:
        return
    low, first, middle, third, high = np.quantile(values, [0.01, 0.25, 0.5, 0.75, 0.99])
    axis.plot([low, high], [place, place], color=look.colour, linewidth=1.0)
    axis.plot(
        [first, third], [place, place], color=look.colour, linewidth=6.0, solid_capstyle="butt"
    )
    axis.plot(middle, place, look.marker, color="white", markeredgecolor=look.colour)


def _points(axis: Axes, lines: pd.DataFrame, look: Look, label: str) -> None:
    main = lines[lines.main]
    error = np.maximum(float(main.paper_position_error_mm_mean.iloc[0]), FLOOR_MM)
    ordered = lines.sort_values("batch_size")
    times = ordered.time_per_pose_mean_us.to_numpy()
    axis.plot(times, np.full(len(times), error), color=look.colour, linewidth=0.8)
    axis.plot(times, np.full(len(times), error), look.marker, color=look.colour, label=label)
    if len(ordered) > 1:  # large batches cost about the same a pose: only the ends are told
        for place in (0, -1):
            batch = f"{ordered.batch_size.iloc[place]:g}"
            where = (times[place], error)
            axis.annotate(batch, where, (0, 5), textcoords="offset points", ha="center", size=6)


def _front(axis: Axes, lines: pd.DataFrame) -> None:
    """Solvers that no other beats in both time and error, joined by steps."""
    errors = lines[lines.main].set_index("solver").paper_position_error_mm_mean
    points = sorted(
        (time, max(errors[solver], FLOOR_MM))
        for solver, time in zip(lines.solver, lines.time_per_pose_mean_us, strict=True)
    )
    front: list[tuple[float, float]] = []
    for time, error in points:
        if not front or error < front[-1][1]:
            front.append((time, error))
    x, y = zip(*front, strict=True)
    axis.step(x, y, where="post", color=SOFT, linewidth=4, alpha=0.25, label="Pareto front")


def _published_points(axis: Axes, published: Published, robot: str) -> None:
    """Stars for the paper's solvers; labels of neighbours are kept apart."""
    points = []
    for method in published.methods("numerical_comparison", robot):
        time = published.number("numerical_comparison", robot, method, "time_per_pose")
        error = published.number("numerical_comparison", robot, method, "position_error_mean")
        if time is not None and error is not None:
            points.append((error, time * 1e3, solver_title(method)))
    below = 0.0
    for error, time, title in sorted(points):
        axis.plot(time, error, "*", color="white", markeredgecolor=SOFT, ms=8, label="paper")
        shift = (5, 2) if error < 1.6 * below else (5, -5)
        axis.annotate(title, (time, error), shift, textcoords="offset points", size=6, color=SOFT)
        below = error
