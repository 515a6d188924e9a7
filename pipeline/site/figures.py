"""Figures that answer to the pointer: error against time, success within a time."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Mapping
from typing import Any

import pandas as pd
from markupsafe import Markup

from pipeline.leaderboard.schema import limits_of
from pipeline.leaderboard.standings import on_front
from pipeline.presentation.columns import plain, significant
from pipeline.presentation.naming import NEURAL, ordered_robots, robot_title, solver_title
from pipeline.site.charts import Axis, Curve, Mark, curves, decades, scatter
from pipeline.site.parts import Chart
from pipeline.site.sheet import slug

LEAST_MM = 1e-6  # errors of nothing have a place on a logarithmic axis too


def is_neural(solver: str) -> bool:
    """Whether a solver is drawn as a neural one."""
    return solver.partition("@")[0] in NEURAL


def error_and_time(summary: pd.DataFrame) -> list[Chart]:
    """Draw median error against time for each robot of an evaluation, one pose a call.

    Args:
        summary: Of `pipeline.reporting.summary.summarise`.
    """
    found = []
    single = summary[summary.batch_size == 1] if len(summary) else summary
    for robot in ordered_robots(single.robot) if len(single) else ():
        mine = single[single.robot == robot].rename(
            columns={
                "time_per_pose_mean_us": "time_geometric_us",
                "position_error_mm_median": "position_median_mm",
            }
        )
        mine = mine[(mine.time_geometric_us > 0) & mine.position_median_mm.notna()]
        if mine.empty:  # no time is known, or no pose was answered and none counts
            continue
        found.append(
            Chart(
                f"error-time-{slug(robot)}",
                "Error and time",
                "Median position error and mean time of a call with one pose. The line joins those "
                "that no other beats in both.",
                _scatter(
                    mine.assign(front=on_front(mine)),
                    f"Error and time: {robot_title(robot)}",
                    "mean time of a call [µs]",
                ),
                "error-time",
                robot_title(robot),
            )
        )
    return found


def board_charts(lines: pd.DataFrame) -> Iterator[Chart]:
    """Draw error against time, and success within a time, of each board whose calls were timed.

    Args:
        lines: Of `pipeline.leaderboard.standings.ranked`.
    """
    timed = lines[lines.time_geometric_us > 0] if len(lines) else lines
    groups = timed.groupby(["machine", "robot", "suite"], sort=False) if len(timed) else ()
    for named, board in groups:
        machine, robot, suite = map(str, named)
        choice = f"{robot_title(robot)}, {plain(suite)}, {machine}"
        key = slug(f"{machine}-{robot}-{suite}")
        yield Chart(
            f"profile-{key}",
            "Success within a time",
            "Share of poses that calls of at most so long solve; of poses that cannot be reached, "
            "that they deny.",
            _profile(board, f"Success within a time: {choice}"),
            "profile",
            choice,
        )
        yield Chart(
            f"pareto-{key}",
            "Error and time",
            "Median position error and shifted geometric mean of the time of a call. The line "
            "joins those that no other beats in both.",
            _scatter(board, f"Error and time: {choice}", "time of a call, geometric mean [µs]"),
            "pareto",
            choice,
        )


def _scatter(lines: pd.DataFrame, title: str, time: str) -> Markup:
    marks = [_mark(line) for line in lines.to_dict("records")]
    return scatter(
        marks,
        decades(time, [mark.x for mark in marks]),
        decades("median position error [mm]", [mark.y for mark in marks]),
        title,
    )


def _mark(line: Mapping[Hashable, Any]) -> Mark:
    """A solver of a board or of an evaluation as a point."""
    name, error, time = line["solver"], line["position_median_mm"], line["time_geometric_us"]
    said = f"{significant(error, 3)} mm, {significant(time, 3)} µs a call"
    title = solver_title(name)
    place = (time, max(error, LEAST_MM))
    return Mark(title, *place, f"{title}: {said}", is_neural(name), bool(line["front"]))


def _profile(board: pd.DataFrame, title: str) -> Markup:
    names = limits_of(board)
    limits = [float(name.removeprefix("within_").removesuffix("us")) for name in names]
    lines = [
        Curve(
            solver_title(line["solver"]),
            [(limit, line[n] / line["poses"]) for limit, n in zip(limits, names, strict=True)],
            f"{solver_title(line['solver'])}: {_half(line, names, limits)}",
            is_neural(line["solver"]),
        )
        for line in board.to_dict("records")
    ]
    x = Axis("time of a call, at most [µs]", limits[0], limits[-1])
    return curves(lines, x, Axis("share of poses solved", 0.0, 1.0, log=False), title)


def _half(line: Mapping[Hashable, Any], names: list[str], limits: list[float]) -> str:
    """What the pointer shows of a curve: where it ends, and where half of the poses are solved."""
    said = f"{line[names[-1]] / line['poses']:.1%} in the end"
    half = next(
        (t for t, n in zip(limits, names, strict=True) if 2 * line[n] >= line["poses"]), None
    )
    return said if half is None else f"{said}, half within {half:g} µs"
