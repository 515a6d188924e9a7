"""Tables of grasp trials beyond the paper's figure: by object, by place, and of studies."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from pipeline.evaluation.statistics import wilson_interval
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import OUTCOMES, ordered_robots, outcome_key, robot_title
from pipeline.reporting.naming import solver_title as titled
from pipeline.reporting.results import Results
from pipeline.reporting.table import Cell, Column, Table

# Settings that a study varies: their column in the raw rows, and how a value is called.
AXES = {
    "solver": ("solver", "solver"),
    "position_error": ("position_error_mm", "error of the place [mm]"),
    "tension_scale": ("tension_scale", "tension [times the scene's]"),
    "friction_scale": ("friction_scale", "friction [times the scene's]"),
    "rate": ("rate_hz", "rate [Hz]"),
    "iterations": ("iterations", "solver iterations"),
}
PLACE = {"object", "row", "x_m", "y_m"}
SIDES = {True: "left", False: "right"}  # of the middle of what was laid, seen by the robot


def grasp_objects(results: Results, config: ReportConfig) -> Table:
    """Success by object, by row of the action area and by side."""
    table = Table(
        name="grasp_success_by",
        title="Success by object and by place",
        caption=f"Share of trials that succeeded with {config.confidence * 100:g} % Wilson "
        "intervals. Rows are counted from the near side; sides are as the robot sees them.",
        columns=[
            Column("robot", "Robot"),
            Column("by", "by"),
            Column("value", "value"),
            *_shares(),
        ],
    )
    trials_of = with_places(results.grasp)
    for robot in ordered_robots(trials_of):
        trials = trials_of[robot]
        middle = 0.5 * (trials["y_m"].min() + trials["y_m"].max())
        groups = {
            "object": trials["object"].str.replace("_", " "),
            "row": trials["row"] + 1,
            "side": (trials["y_m"] > middle).map(SIDES),
        }
        for by, keys in groups.items():
            for value, part in trials.groupby(keys, sort=True):
                cells = success_cells(part, config)
                table.add(robot=robot_title(robot), by=by, value=str(value), **cells)
    return table


def grasp_studies(results: Results, config: ReportConfig) -> Table:
    """Success of every variant of every study."""
    table = Table(
        name="grasp_studies",
        title="What a grasp depends on",
        caption="The same trials with one or two settings varied; shares with "
        f"{config.confidence * 100:g} % Wilson intervals. Plan time: median of the approach.",
        columns=[
            Column("study", "Study"),
            Column("robot", "Robot"),
            Column("variant", "variant"),
            *_shares(),
            Column("slipped", "slipped", "failures", 2),
            Column("not_grasped", "not grasped", "failures", 2),
            Column("plan_ms", "plan [ms]", digits=3),
        ],
    )
    for robot, study in sorted(results.grasp_studies, key=lambda key: (key[1], key[0])):
        rows = results.grasp_studies[robot, study]
        axes = study_axes(rows)
        for values, part in rows.groupby([AXES[axis][0] for axis in axes], sort=False):
            named = [_called(axis, value) for axis, value in zip(axes, values, strict=True)]
            counts = part["class"].map(outcome_key).value_counts()
            table.add(
                study=study.replace("_", " "),
                robot=robot_title(robot),
                variant=", ".join(named),
                slipped=int(counts.get("slipped", 0)),
                not_grasped=int(counts.get("not_grasped", 0)),
                plan_ms=float(part["approach_plan_ms"].median()),
                **success_cells(part, config),
            )
    return table


def with_places(grasps: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Trials of the robots whose rows say what lay where."""
    return {robot: rows for robot, rows in grasps.items() if set(rows.columns) >= PLACE}


def study_axes(rows: pd.DataFrame) -> list[str]:
    """Settings that a study's rows were varied in."""
    return [axis for axis in str(rows["axes"].iloc[0]).split(",") if axis in AXES]


def success_cells(trials: pd.DataFrame, config: ReportConfig) -> dict[str, Cell]:
    """Trials, successes and their share with its interval."""
    successes = int((trials["class"] == OUTCOMES["success"]).sum())
    share = wilson_interval(successes, len(trials), config.confidence)
    return {
        "trials": len(trials),
        "count": successes,
        "share": share.estimate,
        "share_low": share.low,
        "share_high": share.high,
    }


def _shares() -> list[Column]:
    return [
        Column("trials", "trials"),
        Column("count", "successes"),
        Column("share", "share", "success [%]", percent=1),
        Column("share_low", "from", "success [%]", percent=1),
        Column("share_high", "to", "success [%]", percent=1),
    ]


def _called(axis: str, value: object) -> str:
    if axis == "solver":
        return titled(str(value))
    return f"{AXES[axis][1]} {value:g}"
