"""Tables of planning and grasping, with the paper's numbers beside."""

from __future__ import annotations

import pandas as pd

from pipeline.evaluation.statistics import wilson_interval
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import (
    OUTCOMES,
    ordered_robots,
    ordered_solvers,
    outcome_key,
    robot_title,
    solver_title,
)
from pipeline.reporting.published import Published
from pipeline.reporting.results import Results
from pipeline.reporting.table import Cell, Column, Table

PLANNER_ROBOTS = ("nico", "nicol")  # the paper states one time for both
PUBLISHED_TRIALS = 100
PRECISE_MM = 1.0  # mm, tip error along a path that was followed
FLIPS = "plans without a flip [%]"


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
            Column("time_median_ms", "median", "plan time [ms]", 3),
            Column("time_p99_ms", "p99", "plan time [ms]", 3),
            Column("time_paper_ms", "paper", "plan time [ms]", 3),
            Column("tip_error_mean_mm", "mean", "tip error along the path [mm]", 3),
            Column(
                "tip_error_median_mm", "median of the largest", "tip error along the path [mm]", 3
            ),
            Column("largest_step_rad", "largest joint step, median [rad]", digits=3),
            Column("query_without_flip", "query alone", FLIPS, percent=1),
            Column("without_flip", "repaired", FLIPS, percent=1),
            Column("followed_without_flip", "of those that can be followed", FLIPS, percent=1),
        ],
        notes=[
            "A flip: a joint steps by more than 0.5 rad (or m) from one waypoint to the next and, "
            "half way in the joints, the tip is off the path by more than 20 mm or 0.2 rad and by "
            "more than half of its own step. A plan counts as without a flip only if the solver "
            "or the repair claims every waypoint; of the query alone, flips are counted whatever "
            "it claims.",
        ],
    )
    paper = published.number("planner", "nico_nicol", "cycleik", "time_per_50_point_plan")
    for robot in ordered_robots(results.plan):
        every = with_paths_judged(one_row_a_plan(results.plan[robot]))
        for solver in ordered_solvers(every.solver):
            plans = every[every.solver == solver]
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
                largest_step_rad=_quantile(rows, "largest_step_rad", 0.5),
                query_without_flip=_share(rows.query_flips == 0) if "query_flips" in rows else None,
                without_flip=_share(rows.smooth),
                followed_without_flip=_share(rows.smooth[rows.continuous]),
            )
    return table


def grasping(results: Results, published: Published, config: ReportConfig) -> Table:
    """Figure 5 as a table: the share of each outcome, this run in simulation beside the paper."""
    table = Table(
        name="figure5_grasping",
        title="Figure 5: outcomes of grasp trials",
        caption=f"Share of trials by outcome with {config.confidence * 100:g} % Wilson intervals. "
        "This run is physics simulation; the paper's 100 trials a robot are on hardware, with its "
        "detector and language model.",
        columns=[
            Column("robot", "Robot"),
            Column("outcome", "Outcome"),
            Column("trials", "trials"),
            Column("count", "count"),
            Column("share", "ours", "share [%]", percent=1),
            Column("share_low", "from", "share [%]", percent=1),
            Column("share_high", "to", "share [%]", percent=1),
            Column("share_paper", "paper", "share [%]", percent=0),
            Column("share_difference", "Δ", "share [%]", percent=1, signed=True),
        ],
    )
    for robot in ordered_robots([*results.grasp, *published.robots("grasping")]):
        trials = results.grasp.get(robot)
        for key, title in OUTCOMES.items():
            paper = published.number("grasping", robot, "cycleik", key)
            paper = None if paper is None else paper / PUBLISHED_TRIALS
            cells: dict[str, Cell] = {"share_paper": paper}
            if trials is not None:
                count = int((trials["class"].map(outcome_key) == key).sum())
                share = wilson_interval(count, len(trials), config.confidence)
                cells |= {"trials": len(trials), "count": count, "share": share.estimate}
                cells |= {"share_low": share.low, "share_high": share.high}
                cells["share_difference"] = None if paper is None else share.estimate - paper
            table.add(robot=robot_title(robot), outcome=title, **cells)
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
    }
    present = {name: rule for name, rule in how.items() if name in rows.columns}
    return rows.groupby(["solver", "pair"], sort=False).agg(present).reset_index()


def with_paths_judged(plans: pd.DataFrame) -> pd.DataFrame:
    """Add what the columns `in_reach`, `continuous` and `smooth` lack.

    A precise plan without a flip by any solver shows that the path can be followed, should the
    search have missed it. Rows that were not judged count as in reach.
    """
    plans = plans.copy()
    plans["smooth"] = plans.flips == 0
    if "waypoints_found" in plans:
        plans["smooth"] &= plans.waypoints_found == plans.waypoints
    followed = plans.smooth & (plans.tip_error_mm < PRECISE_MM)
    shown = followed.groupby(plans.pair).transform("any")
    for name in ("in_reach", "continuous"):
        known = plans[name].astype(bool) if name in plans else pd.Series(True, plans.index)
        plans[name] = known | shown
    return plans


def _quantile(rows: pd.DataFrame, column: str, share: float) -> float | None:
    return float(rows[column].quantile(share)) if column in rows else None


def _share(holds: pd.Series) -> float | None:
    return float(holds.mean()) if len(holds) else None


def _mean(rows: pd.DataFrame, column: str) -> float | None:
    return float(rows[column].mean()) if column in rows else None
