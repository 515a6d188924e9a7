"""How precise solvers are: errors, success at any tolerance, and where in the workspace."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pipeline.presentation.columns import ROBOT, SOLVER, Column, count, number, share, under
from pipeline.presentation.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.presentation.style import (
    SOFT,
    Look,
    label_first_column,
    legend_below,
    logarithmic,
    looks,
    panels,
    robot_panels,
)
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig, tolerance_title
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.summary import counted, in_order

Rows = Mapping[tuple[str, str], pd.DataFrame]
MAPPED = "cycleik"  # the solver whose precision is shown over the workspace
TOLERANCES = np.geomspace(1e-2, 3e2, 241)  # mm and deg at once
FLOOR_MM, FLOOR_DEG = 1e-4, 1e-5  # errors below are drawn here: the axes are logarithmic
KINDS = (
    ("position_error_mm", "position error [mm]", FLOOR_MM),
    ("rotation_error_deg", "rotation error [deg]", FLOOR_DEG),
)

POSITION, ROTATION = (label for _, label, _ in KINDS)
BEFORE_SEEDS = (
    ROBOT,
    SOLVER,
    count("poses", "poses"),
    *under(
        POSITION,
        number("position_mean_mm", "mean", "position_error_mm_mean"),
        number("position_low_mm", "from", "position_error_mm_mean_low"),
        number("position_high_mm", "to", "position_error_mm_mean_high"),
    ),
)
OVER_SEEDS = under(
    POSITION,
    count("seeds", "seeds"),
    number("position_seeds_low_mm", "seeds, from", "position_error_mm_mean_seeds_low"),
    number("position_seeds_high_mm", "seeds, to", "position_error_mm_mean_seeds_high"),
)
AFTER_SEEDS = (
    *under(
        POSITION,
        number("position_median_mm", "median", "position_error_mm_median"),
        number("position_p90_mm", "p90", "position_error_mm_p90"),
        number("position_p99_mm", "p99", "position_error_mm_p99"),
    ),
    *under(
        ROTATION,
        number("rotation_mean_deg", "mean", "rotation_error_deg_mean"),
        number("rotation_median_deg", "median", "rotation_error_deg_median"),
        number("rotation_p99_deg", "p99", "rotation_error_deg_p99"),
    ),
)
CLAIMS = under(
    "claims",
    share("found", "found [%]"),
    count("claimed_and_wrong", "wrong"),
    count("outside_limits", "off limits"),
)


def _successes(config: ReportConfig) -> tuple[Column, ...]:
    """Columns of success at the two tolerances, named by them."""
    strict, loose = config.success.strict, config.success.loose
    return (
        *under(
            f"{tolerance_title(strict)} [%]",
            share("strict", "rate", "success_strict", 2),
            share("strict_low", "from", "success_strict_low", 2),
            share("strict_high", "to", "success_strict_high", 2),
        ),
        share("loose", f"{tolerance_title(loose)} [%]", "success_loose", 2),
    )


def precision(summary: pd.DataFrame, config: ReportConfig) -> Table:
    """Our own table: Euclidean and geodesic errors, success at two tolerances, claims.

    Args:
        summary: From `summarise`; may be empty. The interval over training seeds has columns where
            there are several trainings of any network.
        config: The two tolerances, and the confidence.
    """
    several = len(summary) and (summary.seeds > 1).any()
    return Table.of(
        in_order(summary[summary.main] if len(summary) else summary),
        [
            *BEFORE_SEEDS,
            *(OVER_SEEDS if several else ()),
            *AFTER_SEEDS,
            *_successes(config),
            *CLAIMS,
        ],
        name="precision",
        title="Precision, Euclidean and geodesic",
        caption="Recomputed from the joints; success is with joint limits kept. Intervals are "
        f"{config.confidence * 100:g} %: Wilson for rates, bootstrap for means, over poses and, "
        "where there are several trainings, separately over their seeds.",
    )


def success_against_tolerance(rows: Rows, config: ReportConfig) -> Figure:
    """Share of poses within x mm and x deg, for all x: one tolerance is one vertical line."""
    look = looks(solver for _, solver in rows)
    figure, axes = robot_panels((robot for robot, _ in rows), 3.7, 3.0)
    for robot, axis in axes.items():
        for solver in _of(rows, robot):
            mine = counted(rows[robot, solver], config)
            worse = np.maximum(
                mine.position_error_mm.to_numpy(), mine.rotation_error_deg.to_numpy()
            )
            reached = worse[mine.within_limits.to_numpy(dtype=bool) & ~np.isnan(worse)]
            within = np.searchsorted(np.sort(reached), TOLERANCES, side="left") / len(mine)
            # Markers of each line start elsewhere, so that lines on top of each other show.
            offset = list(look).index(solver) * 7 % 40
            axis.plot(
                TOLERANCES,
                within * 100,
                color=look[solver].colour,
                linestyle=look[solver].line,
                marker=look[solver].marker,
                markevery=(offset, 40),
                label=solver_title(solver),
            )
        axis.axvline(1.0, color=SOFT, linewidth=0.8, zorder=0)
        axis.set(ylim=(-2, 102), xlabel="tolerance [mm and deg]")
        logarithmic(axis, "x")
    legend_below(figure, axes.values(), label="poses within [%]")
    return figure


def error_distributions(rows: Rows, config: ReportConfig) -> Figure:
    """Median, middle half and 1st to 99th percentile of both errors, one line a solver."""
    robots = ordered_robots(robot for robot, _ in rows)
    look = looks(solver for _, solver in rows)
    most = max(len(_of(rows, robot)) for robot in robots)
    figure, axes = panels(len(robots) * len(KINDS), 3.7, 0.9 + 0.26 * most, columns=len(KINDS))
    places = [(robot, kind) for robot in robots for kind in KINDS]
    for axis, (robot, (column, label, floor)) in zip(axes, places, strict=True):
        solvers = _of(rows, robot)
        for place, solver in enumerate(solvers):
            values = counted(rows[robot, solver], config)[column].dropna().to_numpy()
            _draw_spread(axis, place, np.maximum(values, floor), look[solver])
        names = [solver_title(name) for name in solvers]
        axis.set_yticks(range(len(names)), names if column == KINDS[0][0] else [""] * len(names))
        axis.set(xlabel=label, ylim=(len(solvers) - 0.5, -0.5), title=robot_title(robot))
        logarithmic(axis, "x")
        axis.grid(visible=False, axis="y")
    return figure


def workspace_map(rows: Rows, solver: str, config: ReportConfig) -> Figure:
    """Median position error over the workspace, seen from the side: distance from the axis, z."""
    figure, axes = robot_panels((robot for robot, name in rows if name == solver), 3.7, 3.1)
    for robot, axis in axes.items():
        mine = counted(rows[robot, solver], config).dropna(subset=["position_error_mm"])
        radius = np.hypot(mine.target_x_m.to_numpy(), mine.target_y_m.to_numpy())
        height = mine.target_z_m.to_numpy()
        drawn = axis.hexbin(
            radius,
            height,
            C=np.maximum(mine.position_error_mm, FLOOR_MM),
            reduce_C_function=np.median,
            gridsize=_hexagons(radius, height),
            bins="log",
            cmap="cividis_r",
            linewidths=0.2,
        )
        axis.set_xlabel("distance from the base axis [m]")
        axis.set_aspect("equal")
        bar = figure.colorbar(drawn, ax=axis, fraction=0.05)
        bar.set_label("median position error [mm]")
        logarithmic(bar.ax, "y")
    label_first_column(axes.values(), "height [m]")
    return figure


def _of(rows: Rows, robot: str) -> list[str]:
    return ordered_solvers(solver for name, solver in rows if name == robot)


def _draw_spread(axis: Axes, place: int, values: NDArray[np.float64], look: Look) -> None:
    if values.size == 0:
        return
    low, first, middle, third, high = np.quantile(values, [0.01, 0.25, 0.5, 0.75, 0.99])
    axis.plot([low, high], [place, place], color=look.colour, linewidth=1.0)
    axis.plot(
        [first, third], [place, place], color=look.colour, linewidth=6.0, solid_capstyle="butt"
    )
    axis.plot(middle, place, look.marker, color="white", markeredgecolor=look.colour)


def _hexagons(radius: NDArray[np.float64], height: NDArray[np.float64]) -> tuple[int, int]:
    """Hexagons side by side and on top of each other: regular ones, of about 16 poses each."""
    width, tall = max(float(np.ptp(radius)), 1e-6), max(float(np.ptp(height)), 1e-6)
    across = max(int(np.sqrt(len(radius) / 16 * width / tall)), 4)
    return across, max(int(across * tall / width / np.sqrt(3)), 2)


TOPIC = Topic(
    tables=(lambda data: precision(data.summary, data.config),),
    plots=(
        Plot(
            "success_against_tolerance",
            "Share of test poses within a tolerance of x mm and x deg (Euclidean, geodesic, joint "
            "limits kept). The line at 1 is the success at 1 mm / 1 deg.",
            lambda data: data.results.evaluate,
            lambda data: success_against_tolerance(data.results.evaluate, data.config),
        ),
        Plot(
            "error_distributions",
            "Median (marker), middle half (thick) and 1st to 99th percentile (thin) of the errors.",
            lambda data: data.results.evaluate,
            lambda data: error_distributions(data.results.evaluate, data.config),
        ),
        Plot(
            "workspace_map",
            "Median position error of CycleIK over the workspace: distance from the base's "
            "vertical axis, and height.",
            lambda data: [solver for _, solver in data.results.evaluate if solver == MAPPED],
            lambda data: workspace_map(data.results.evaluate, MAPPED, data.config),
        ),
    ),
)
