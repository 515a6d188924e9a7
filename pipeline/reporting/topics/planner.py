"""The planner benchmark: time, error and flips, and where another curve was driven."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from pipeline.presentation.columns import ROBOT, SOLVER, count, number, share, under
from pipeline.presentation.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.presentation.published import Published
from pipeline.presentation.style import (
    INK,
    LOOKS,
    legend_below,
    logarithmic,
    looks,
    reference_line,
    robot_panels,
)
from pipeline.presentation.table import Table
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.results import Results

PLANNER_ROBOTS = ("nico", "nicol")  # the paper states one time for both
PRECISE_MM = 1.0  # mm, tip error along a path that was followed
SMALLEST_MM = 1e-4  # mm, smaller tip errors are drawn here
ALONE = "without a flip before repair"
MARGIN = 4.0  # % between the number of a part and its end
WIDEST = 0.12  # share below which a part of a bar has no room for its number
AGGREGATES = {
    "plan_time_ms": "first",
    "tip_error_mm": "max",
    "tip_error_mean_mm": "mean",
    "largest_step_rad": "max",
    "flips": "max",
    "query_flips": "max",
    "waypoints": "max",
    "waypoints_found": "min",
    "in_reach": "first",
    "continuous": "first",
    "rerouted": "first",
    "detour_mm": "max",
    "length_m": "max",
    "requested_length_m": "max",
    "collisions": "max",
    "limit_violations": "max",
}  # of the rows of a plan that were stored by waypoint


@dataclass(frozen=True)
class Plans:
    """Judged plans of a solver on a robot.

    Attributes:
        robot: Name of the robot.
        solver: Name of the solver.
        rows: One row a plan, as `with_paths_judged` returns them.
        time_paper_ms: The paper's plan time [ms], where it states one.
    """

    robot: str
    solver: str
    rows: pd.DataFrame
    time_paper_ms: float | None = None

    def where(self, *flags: str) -> pd.DataFrame:
        """Return the plans for which all of some flags hold."""
        return self.rows[self.rows[list(flags)].all(axis=1)]


def one_row_a_plan(rows: pd.DataFrame) -> pd.DataFrame:
    """Bring planner rows to one a plan, whether they were stored by plan or by waypoint."""
    present = {name: rule for name, rule in AGGREGATES.items() if name in rows.columns}
    return rows.groupby(["solver", "pair"], sort=False).agg(present).reset_index()


def with_paths_judged(plans: pd.DataFrame) -> pd.DataFrame:
    """Add what the columns `in_reach`, `continuous`, `rerouted` and `smooth` lack.

    A precise plan without a flip by any solver on the requested path shows that this path can be
    followed, should the search have missed it. Rows that were not judged count as in reach.
    """
    plans = plans.copy()
    plans["rerouted"] = plans["rerouted"].astype(bool) if "rerouted" in plans else False
    plans["smooth"] = plans.flips == 0
    if "waypoints_found" in plans:
        plans["smooth"] &= plans.waypoints_found == plans.waypoints
    plans["direct"], plans["other"] = ~plans.rerouted, plans.smooth & plans.rerouted
    plans["followed"] = plans.smooth & plans.direct
    precise = plans.followed & (plans.tip_error_mm < PRECISE_MM)
    shown = precise.groupby(plans.pair).transform("any")
    for name in ("in_reach", "continuous"):
        known = plans[name].astype(bool) if name in plans else pd.Series(True, plans.index)
        plans[name] = known | shown
    plans["beyond"], plans["flips_left"] = ~plans.in_reach, ~plans.smooth
    if "query_flips" in plans:
        plans["query_smooth"] = plans.query_flips == 0
    if "detour_mm" in plans:
        plans["hit"], plans["over_limits"] = plans.collisions > 0, plans.limit_violations > 0
        plans["longer"] = plans.length_m / plans.requested_length_m
    return plans


def _count(*flags: str) -> Callable[[Plans], int]:
    return lambda plans: len(plans.where(*flags))


def _mean(column: str, *flags: str) -> Callable[[Plans], Any]:
    """Mean, or share of what holds, over the plans with some flags."""
    return lambda plans: plans.where(*flags)[column].mean() if column in plans.rows else None


def _quantile(at: float, column: str, *flags: str) -> Callable[[Plans], Any]:
    return lambda plans: plans.where(*flags)[column].quantile(at) if column in plans.rows else None


PLANNER = (
    ROBOT,
    SOLVER,
    *under(
        "plans",
        count("plans", "all", _count()),
        count("in_reach", "in reach", _count("in_reach")),
        count("continuous", "can be followed", _count("continuous")),
    ),
    *under(
        "plan time [ms]",
        number("time_median_ms", "median", _quantile(0.5, "plan_time_ms", "in_reach")),
        number("time_p99_ms", "p99", _quantile(0.99, "plan_time_ms", "in_reach")),
        number("time_paper_ms", "paper"),
    ),
    *under(
        "tip error along the path [mm]",
        number("tip_error_mean_mm", "mean", _mean("tip_error_mean_mm", "in_reach")),
        number(
            "tip_error_median_mm",
            "median of the largest",
            _quantile(0.5, "tip_error_mm", "in_reach"),
        ),
        number(
            "tip_error_largest_mm",
            "largest without a flip",
            _quantile(1.0, "tip_error_mm", "in_reach", "smooth"),
        ),
    ),
    number(
        "largest_step_rad",
        "largest joint step, median [rad]",
        _quantile(0.5, "largest_step_rad", "in_reach"),
    ),
    *under(
        "plans without a flip [%]",
        share("query_without_flip", "query alone", _mean("query_smooth", "in_reach")),
        share("requested_without_flip", "on the requested path", _mean("followed", "in_reach")),
        share("without_flip", "requested path or another curve", _mean("smooth", "in_reach")),
        share(
            "followed_without_flip",
            "requested path, of those that can be followed",
            _mean("followed", "in_reach", "continuous"),
        ),
    ),
)


def planner(results: Results, published: Published) -> Table:
    """The planner benchmark; the paper states one time for 50 poses on NICO and NICOL."""
    return Table.of(
        [replace(plans, time_paper_ms=_stated(plans, published)) for plans in _by_solver(results)],
        PLANNER,
        name="planner",
        title="Motion planner",
        caption="Random start-target pairs, 50 poses a plan in one batched query. A path is in "
        "reach if every waypoint by itself has a solution; it can be followed if a search found "
        "joints through all of them without a branch flip. Times, errors and flips are those of "
        "plans in reach. The paper states about 70 ms for a plan on NICO and NICOL.",
        notes=[
            "A flip: a joint steps by more than 0.5 rad (or m) from one waypoint to the next and, "
            "half way in the joints, the tip is off the path by more than 20 mm or 0.2 rad and by "
            "more than half of its own step. A plan counts as without a flip only if the solver "
            "or the repair claims every waypoint; of the query alone, flips are counted whatever "
            "it claims. Errors are those along the curve that is driven.",
        ],
    )


def _stated(plans: Plans, published: Published) -> float | None:
    """Return the paper's plan time [ms], which it states for CycleIK on two robots."""
    if plans.solver != "cycleik" or plans.robot not in PLANNER_ROBOTS:
        return None
    return published.number("planner", "nico_nicol", "cycleik", "time_per_50_point_plan")


ROUTES = (
    ROBOT,
    SOLVER,
    *under(
        "plans in reach",
        count("in_reach", "all", _count("in_reach")),
        count("in_reach_rerouted", "on another curve", _count("in_reach", "other")),
        count("in_reach_failed", "with a flip", _count("in_reach", "flips_left")),
    ),
    *under(
        "plans out of reach",
        count("beyond", "all", _count("beyond")),
        count("beyond_rerouted", "on another curve", _count("beyond", "other")),
    ),
    *under(
        "plan time, in reach, median [ms]",
        number(
            "time_requested_ms",
            "requested path",
            _quantile(0.5, "plan_time_ms", "in_reach", "direct"),
        ),
        number(
            "time_rerouted_ms",
            "on another curve",
            _quantile(0.5, "plan_time_ms", "in_reach", "other"),
        ),
    ),
    *under(
        "other curves, in reach, median",
        number("detour_mm", "distance [mm]", _quantile(0.5, "detour_mm", "in_reach", "other")),
        number("longer", "longer [times]", _quantile(0.5, "longer", "in_reach", "other")),
    ),
    *under(
        "plans with a collision [%]",
        share("hit_requested", "requested path", _mean("hit", "followed")),
        share("hit_rerouted", "on another curve", _mean("hit", "rerouted")),
    ),
    count("limits", "plans beyond joint limits", _count("over_limits")),
)


def planner_routes(results: Results) -> Table:
    """Plans whose requested path no joints follow, and the curves driven instead."""
    return Table.of(
        [plans for plans in _by_solver(results) if "detour_mm" in plans.rows],
        ROUTES,
        name="planner_routes",
        title="Motion planner: other curves",
        caption="Where no joints follow the requested path, another Bezier curve between "
        "the same ends is driven, derived from a path in joint space and drawn back towards "
        "the requested one. The distance is the largest at the same path parameter.",
        notes=[
            "A collision: the robot touches itself or the table it stands at in at least one of "
            "the 50 waypoints. The planner avoids none on the requested path; of other curves it "
            "prefers those without. Both shares are of plans without a flip, in reach or not.",
        ],
    )


def planner_times(plans: Mapping[str, pd.DataFrame], published: Published) -> Figure:
    """Plan time and largest tip error of every plan, by solver."""
    figure, axes = robot_panels(plans, 3.7, 3.0)
    look = looks(solver for rows in plans.values() for solver in rows.solver)
    paper = published.number("planner", "nico_nicol", "cycleik", "time_per_50_point_plan")
    for robot, axis in axes.items():
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
            reference_line(axis, "x", paper, "paper's plan time")
        axis.set_xlabel("time of a plan of 50 poses [ms]")
        logarithmic(axis, "x")
        logarithmic(axis, "y")
    legend_below(figure, axes.values(), label="largest tip error on the path [mm]")
    return figure


def planner_flips(plans: Mapping[str, pd.DataFrame]) -> Figure:
    """Shares of the plans in reach: smooth on the requested path, on another curve, and not."""
    figure, axes = robot_panels(plans, 3.7, 2.2)
    for robot, axis in axes.items():
        every = with_paths_judged(one_row_a_plan(plans[robot]))
        inside = every[every.in_reach]
        _stacked(axis, inside)
        axis.set(title=f"{robot_title(robot)}: {inside.pair.nunique()} paths in reach")
        axis.set(xlim=(0, 100), xlabel="plans [%]")
        axis.grid(visible=False, axis="y")
    legend_below(figure, axes.values(), columns=2)
    return figure


def _stacked(axis: Axes, plans: pd.DataFrame) -> None:
    """One bar a solver, the first on top, with the shares in it."""
    solvers = ordered_solvers(plans.solver)
    places = -np.arange(len(solvers), dtype=float)
    parts = {
        "without a flip, requested path": (plans.followed, LOOKS[0].colour, "white"),
        "without a flip, on another curve": (plans.other, LOOKS[2].colour, INK),
        "with a flip or a waypoint missed": (~plans.smooth, LOOKS[1].colour, "white"),
    }
    left = np.zeros(len(solvers))
    for label, (holds, colour, ink) in parts.items():
        widths = np.array([holds[plans.solver == solver].mean() for solver in solvers])
        axis.barh(places, 100 * widths, 0.72, 100 * left, color=colour, label=label)
        for place, width, start in zip(places, widths, left, strict=True):
            if width >= WIDEST:
                # A diamond may be further left, or on the edge.
                end = 100 * (start + width) - MARGIN
                written = f"{100 * width:.1f}".removesuffix(".0")
                axis.text(end, place, written, color=ink, ha="right", va="center", fontsize=7)
        left += widths
    if "query_flips" in plans:
        alone = [(plans.query_flips[plans.solver == solver] == 0).mean() for solver in solvers]
        (marks,) = axis.plot(100 * np.array(alone), places, "D", label=ALONE, clip_on=False)
        marks.set(markerfacecolor="white", markeredgecolor=INK, markersize=5.5)
    axis.set_yticks(places, [solver_title(solver) for solver in solvers])


def _by_solver(results: Results) -> Iterator[Plans]:
    """Yield the judged plans of every solver on every robot."""
    for robot in ordered_robots(results.plan):
        every = with_paths_judged(one_row_a_plan(results.plan[robot]))
        for solver in ordered_solvers(every.solver):
            yield Plans(robot, solver, every[every.solver == solver])


TOPIC = Topic(
    stages=("plan",),
    tables=(
        lambda data: planner(data.results, data.published),
        lambda data: planner_routes(data.results),
    ),
    plots=(
        Plot(
            "planner_flips",
            "Plans whose path stays in reach: without a branch flip on the requested path, without "
            "one on another curve between the same ends, or neither. Diamonds: the batched query "
            "alone, before any repair.",
            lambda data: data.results.plan,
            lambda data: planner_flips(data.results.plan),
        ),
        Plot(
            "planner_times",
            "Time and largest tip error of every plan; the dashed line is the paper's 70 ms.",
            lambda data: data.results.plan,
            lambda data: planner_times(data.results.plan, data.published),
        ),
    ),
)
