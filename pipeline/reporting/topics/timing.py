"""How fast solvers are, by the paper's protocol and by ours, and what that costs in precision."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.presentation.columns import ROBOT, SOLVER, count, number, text, under
from pipeline.presentation.naming import ordered_solvers, solver_title
from pipeline.presentation.published import Published
from pipeline.presentation.style import SOFT, Look, legend_below, logarithmic, looks, robot_panels
from pipeline.presentation.table import Table
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.summary import in_order
from pipeline.reporting.topics.paper import NUMERICAL
from pipeline.reporting.topics.precision import FLOOR_MM

NEAR = 1.5  # ratio of times below which labels of two points would overlap
COLUMNS = (
    ROBOT,
    SOLVER,
    count("batch_size", "batch size"),
    count("calls", "calls"),
    *under(
        "as the paper [ms]",
        number("sample_ms", "per sample", lambda line: _single(line) / 1e3),
        number("batch_ms", "per batch", "time_per_batch_mean_ms"),
    ),
    *under(
        "time per pose [µs]",
        number("mean_us", "mean", "time_per_pose_mean_us"),
        number("median_us", "median", "time_per_pose_median_us"),
        number("p99_us", "p99", "time_per_pose_p99_us"),
        number("solver_median_us", "own clock, median", "solver_time_median_us"),
    ),
    number("iterations", "iterations, mean", "iterations_mean"),
    count("cores", "cores", "threads"),
    text("pinned", "pinned", lambda line: "yes" if line["pinned"] else "no"),
)


def _single(line: dict[str, Any]) -> float:
    """Mean time of a call at batch size 1 [us], NaN at another."""
    time: float = line["time_per_pose_mean_us"]
    return time if line["batch_size"] == 1 else math.nan


def timing(summary: pd.DataFrame) -> Table:
    """Time by batch size, by the paper's protocol and by ours side by side."""
    return Table.of(
        in_order(summary),
        COLUMNS,
        name="time",
        title="Time",
        caption="Wall time of a call divided by its poses, after a warm-up, on the configured "
        "number of cores. The paper gives the mean per sample at batch size 1 and the mean per "
        "batch. Beside it mean, median and 99th percentile over the calls (of few calls the "
        "percentile is the largest); the solver's own clock leaves out what the call itself "
        "costs.",
    )


def error_against_time(summary: pd.DataFrame, published: Published) -> Figure:
    """Mean error against time per pose, batch sizes apart, with the Pareto front."""
    look = looks(summary.solver)
    figure, axes = robot_panels(summary.robot, 3.7, 3.3)
    for robot, axis in axes.items():
        mine = summary[summary.robot == robot]
        _front(axis, mine)
        for solver in ordered_solvers(mine.solver):
            _points(axis, mine[mine.solver == solver], look[solver], solver_title(solver))
        _published_points(axis, published, robot)
        axis.set_xlabel("time per pose [µs]")
        logarithmic(axis, "x")
        logarithmic(axis, "y")
    legend_below(figure, axes.values(), label="mean error over the axes [mm]")
    return figure


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
    elif len(sizes) > 1:  # large batches cost about the same a pose: only the ends are labelled
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
    for method in published.methods(NUMERICAL, robot):
        time = published.number(NUMERICAL, robot, method, "time_per_pose")
        error = published.number(NUMERICAL, robot, method, "position_error_mean")
        if time is not None and error is not None:
            points.append((error, time * 1e3, solver_title(method)))
    below = 0.0
    for error, time, title in sorted(points):
        axis.plot(time, error, "*", color="white", markeredgecolor=SOFT, ms=8, label="paper")
        shift = (5, 2) if error < 1.6 * below else (5, -5)
        axis.annotate(title, (time, error), shift, textcoords="offset points", size=6, color=SOFT)
        below = error


TOPIC = Topic(
    tables=(lambda data: timing(data.summary),),
    plots=(
        Plot(
            "error_against_time",
            "Mean error in the paper's metric against time per pose; numbers at the points are "
            "batch sizes. Towards the lower left is better. Stars: the paper.",
            lambda data: data.results.evaluate,
            lambda data: error_against_time(data.summary, data.published),
        ),
    ),
)
