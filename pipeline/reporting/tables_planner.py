"""Tables of the planner benchmark: time, error and flips, and where another curve was driven."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from pipeline.reporting.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.reporting.published import Published
from pipeline.reporting.results import Results
from pipeline.reporting.table import Column, Table

PLANNER_ROBOTS = ("nico", "nicol")  # the paper states one time for both
PRECISE_MM = 1.0  # mm, tip error along a path that was followed
FLIPS = "plans without a flip [%]"
TIP_ERROR = "tip error along the path [mm]"
TIME = "plan time [ms]"
COLLISION = "plans with a collision [%]"


def planner(results: Results, published: Published) -> Table:
    """The planner benchmark; the paper states one time for 50 poses on NICO and NICOL."""
    table = Table(
        name="planner",
        title="Motion planner",
        caption="Random start-target pairs, 50 poses a plan in one batched query. A path is in "
        "reach if every waypoint by itself has a solution; it can be followed if a search found "
        "joints through all of them without a branch flip. Times, errors and flips are those of "
        "plans in reach. The paper states about 70 ms for a plan on NICO and NICOL.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("plans", "all", "plans"),
            Column("in_reach", "in reach", "plans"),
            Column("continuous", "can be followed", "plans"),
            Column("time_median_ms", "median", TIME, 3),
            Column("time_p99_ms", "p99", TIME, 3),
            Column("time_paper_ms", "paper", TIME, 3),
            Column("tip_error_mean_mm", "mean", TIP_ERROR, 3),
            Column("tip_error_median_mm", "median of the largest", TIP_ERROR, 3),
            Column("tip_error_largest_mm", "largest without a flip", TIP_ERROR, 3),
            Column("largest_step_rad", "largest joint step, median [rad]", digits=3),
            Column("query_without_flip", "query alone", FLIPS, percent=1),
            Column("requested_without_flip", "on the path as asked", FLIPS, percent=1),
            Column("without_flip", "as asked or on another curve", FLIPS, percent=1),
            Column("followed_without_flip", "as asked, of those that can be", FLIPS, percent=1),
        ],
        notes=[
            "A flip: a joint steps by more than 0.5 rad (or m) from one waypoint to the next and, "
            "half way in the joints, the tip is off the path by more than 20 mm or 0.2 rad and by "
            "more than half of its own step. A plan counts as without a flip only if the solver "
            "or the repair claims every waypoint; of the query alone, flips are counted whatever "
            "it claims. Errors are those along the curve that is driven.",
        ],
    )
    paper = published.number("planner", "nico_nicol", "cycleik", "time_per_50_point_plan")
    for robot, solver, plans in _by_solver(results):
        rows = plans[plans.in_reach]
        stated = solver == "cycleik" and robot in PLANNER_ROBOTS
        table.add(
            robot=robot_title(robot),
            solver=solver_title(solver),
            plans=len(plans),
            in_reach=len(rows),
            continuous=int(plans.continuous.sum()),
            time_median_ms=_quantile(rows, "plan_time_ms", 0.5),
            time_p99_ms=_quantile(rows, "plan_time_ms", 0.99),
            time_paper_ms=paper if stated else None,
            tip_error_mean_mm=_mean(rows, "tip_error_mean_mm"),
            tip_error_median_mm=_quantile(rows, "tip_error_mm", 0.5),
            tip_error_largest_mm=_quantile(rows[rows.smooth], "tip_error_mm", 1.0),
            largest_step_rad=_quantile(rows, "largest_step_rad", 0.5),
            query_without_flip=_share(rows.query_flips == 0) if "query_flips" in rows else None,
            requested_without_flip=_share(rows.smooth & ~rows.rerouted),
            without_flip=_share(rows.smooth),
            followed_without_flip=_share((rows.smooth & ~rows.rerouted)[rows.continuous]),
        )
    return table


def planner_routes(results: Results) -> Table:
    """What came of plans whose path, as it was asked for, no joints follow."""
    table = Table(
        name="planner_routes",
        title="Motion planner: other curves",
        caption="Where no joints follow the path as it was asked for, another Bezier curve between "
        "the same ends is driven, derived from a way between joints and drawn back towards the "
        "path. How far it leads away is the largest distance at the same path parameter.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("in_reach", "all", "plans in reach"),
            Column("in_reach_rerouted", "on another curve", "plans in reach"),
            Column("in_reach_failed", "with a flip", "plans in reach"),
            Column("beyond", "all", "plans out of reach"),
            Column("beyond_rerouted", "on another curve", "plans out of reach"),
            Column("time_requested_ms", "as asked", "plan time, in reach, median [ms]", 3),
            Column("time_rerouted_ms", "on another curve", "plan time, in reach, median [ms]", 3),
            Column("detour_mm", "away, median [mm]", "other curves, in reach", 3),
            Column("longer", "longer, median [times]", "other curves, in reach", 3),
            Column("hit_requested", "as asked", COLLISION, percent=1),
            Column("hit_rerouted", "on another curve", COLLISION, percent=1),
            Column("limits", "plans beyond joint limits"),
        ],
        notes=[
            "A collision: the robot touches itself or the table it stands at in at least one of "
            "the 50 waypoints. The planner avoids none on the path as asked; of other curves it "
            "prefers those without. Both shares are of plans without a flip, in reach or not.",
        ],
    )
    for robot, solver, plans in _by_solver(results):
        if "detour_mm" not in plans:
            continue
        inside, beyond = plans[plans.in_reach], plans[~plans.in_reach]
        requested, other = (part[part.smooth] for part in (plans[~plans.rerouted], inside))
        other, every = other[other.rerouted], plans[plans.rerouted]
        table.add(
            robot=robot_title(robot),
            solver=solver_title(solver),
            in_reach=len(inside),
            in_reach_rerouted=len(other),
            in_reach_failed=int((~inside.smooth).sum()),
            beyond=len(beyond),
            beyond_rerouted=int((beyond.smooth & beyond.rerouted).sum()),
            time_requested_ms=_quantile(inside[~inside.rerouted], "plan_time_ms", 0.5),
            time_rerouted_ms=_quantile(other, "plan_time_ms", 0.5),
            detour_mm=_quantile(other, "detour_mm", 0.5),
            longer=float((other.length_m / other.requested_length_m).median())
            if len(other)
            else None,
            hit_requested=_share(requested.collisions > 0),
            hit_rerouted=_share(every.collisions > 0),
            limits=int((plans.limit_violations > 0).sum()),
        )
    return table


def one_row_a_plan(rows: pd.DataFrame) -> pd.DataFrame:
    """Bring planner rows to one a plan, whether they were stored by plan or by waypoint."""
    how = {
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
    }
    present = {name: rule for name, rule in how.items() if name in rows.columns}
    return rows.groupby(["solver", "pair"], sort=False).agg(present).reset_index()


def with_paths_judged(plans: pd.DataFrame) -> pd.DataFrame:
    """Add what the columns `in_reach`, `continuous`, `rerouted` and `smooth` lack.

    A precise plan without a flip by any solver on the path as asked shows that this path can be
    followed, should the search have missed it. Rows that were not judged count as in reach.
    """
    plans = plans.copy()
    plans["rerouted"] = plans["rerouted"].astype(bool) if "rerouted" in plans else False
    plans["smooth"] = plans.flips == 0
    if "waypoints_found" in plans:
        plans["smooth"] &= plans.waypoints_found == plans.waypoints
    followed = plans.smooth & ~plans.rerouted & (plans.tip_error_mm < PRECISE_MM)
    shown = followed.groupby(plans.pair).transform("any")
    for name in ("in_reach", "continuous"):
        known = plans[name].astype(bool) if name in plans else pd.Series(True, plans.index)
        plans[name] = known | shown
    return plans


def _by_solver(results: Results) -> Iterator[tuple[str, str, pd.DataFrame]]:
    """Yield robot, solver and its judged plans."""
    for robot in ordered_robots(results.plan):
        every = with_paths_judged(one_row_a_plan(results.plan[robot]))
        for solver in ordered_solvers(every.solver):
            yield robot, solver, every[every.solver == solver]


def _quantile(rows: pd.DataFrame, column: str, share: float) -> float | None:
    return float(rows[column].quantile(share)) if column in rows else None


def _share(holds: pd.Series) -> float | None:
    return float(holds.mean()) if len(holds) else None


def _mean(rows: pd.DataFrame, column: str) -> float | None:
    return float(rows[column].mean()) if column in rows else None
