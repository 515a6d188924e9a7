"""Figures of precision and time, solver by solver: pure functions of rows or of their summary."""

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
NEAR = 1.5  # ratio of times below which labels of two points would overlap
FLOOR_MM, FLOOR_DEG = 1e-4, 1e-5  # errors below are drawn here: the axes are logarithmic


def success_against_tolerance(rows: Rows, config: ReportConfig) -> Figure:
    """Share of poses within x mm and x deg, for all x: one tolerance is one vertical line."""
    robots = ordered_robots(robot for robot, _ in rows)
    look = looks(solver for _, solver in rows)
    figure, axes = panels(len(robots), 3.7, 3.0)
    for axis, robot in zip(axes, robots, strict=True):
        for solver in _of(rows, robot):
            mine = counted(rows[robot, solver], config)
            worse = np.maximum(
                mine.position_error_mm.to_numpy(), mine.rotation_error_deg.to_numpy()
            )
            reached = worse[mine.within_limits.to_numpy(dtype=bool) & ~np.isnan(worse)]
            share = np.searchsorted(np.sort(reached), TOLERANCES, side="left") / len(mine)
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
            values = counted(rows[robot, solver], config)[column].dropna().to_numpy()
            _spread(axis, place, np.maximum(values, floor), look[solver])
        names = [solver_title(name) for name in solvers]
        axis.set_yticks(range(len(names)), names if column == kinds[0][0] else [""] * len(names))
        axis.set(xlabel=label, ylim=(len(solvers) - 0.5, -0.5), title=robot_title(robot))
        logarithmic(axis, "x")
        axis.grid(visible=False, axis="y")
    return figure


def look_offset(solver: str, look: Mapping[str, Look]) -> int:
    """Start markers of each line elsewhere, so that lines on top of each other show."""
    return list(look).index(solver) * 7 % 40


def _of(rows: Rows, robot: str) -> list[str]:
    return ordered_solvers(solver for name, solver in rows if name == robot)


def counted(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """The rows that errors are read off, with what a pose without an answer counts."""
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
    sizes = [f"{size:g}" for size in ordered.batch_size]
    if len(sizes) > 1 and times.max() < NEAR * times.min():  # one label where two would overlap
        _label(axis, float(times[-1]), error, f"{sizes[0]}-{sizes[-1]}")
    elif len(sizes) > 1:  # large batches cost about the same a pose: only the ends are told
        for place in (0, -1):
            _label(axis, float(times[place]), error, sizes[place])


def _label(axis: Axes, time: float, error: float, text: str) -> None:
    axis.annotate(text, (time, error), (0, 5), textcoords="offset points", ha="center", size=6)


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
