"""Solvers on suites of hard poses: success, time, what a miss costs, and who is clearly better."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.evaluation.statistics import wilson_interval
from pipeline.presentation.columns import (
    ROBOT,
    SOLVER,
    Column,
    count,
    number,
    plain,
    share,
    text,
    under,
)
from pipeline.presentation.naming import ordered_robots, ordered_solvers, solver_title
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig, tolerance_title
from pipeline.reporting.data import Topic
from pipeline.reporting.summary import apply_not_found, successes

Rows = Mapping[tuple[str, str, str], pd.DataFrame]
Flags = NDArray[np.bool_]

UNREACHABLE, TRACKING = "unreachable", "tracking"
JUMP = 0.1  # rad or m from one waypoint to the next that no trajectory asks for
US_PER_S, US_PER_MS = 1e6, 1e3

SUITE = text("suite", "Suite", convert=plain)
KIND = text("stratum", "Kind", convert=plain)


def _rate(title: str, name: str) -> tuple[Column, ...]:
    return under(
        title,
        share(name, "share", f"{name}_share"),
        share(f"{name}_low", "from"),
        share(f"{name}_high", "to"),
    )


def _time(title: str) -> tuple[Column, ...]:
    return under(
        title, number("time_median_ms", "median"), number("time_p99_ms", "99th percentile")
    )


def _nearest(title: str) -> tuple[Column, ...]:
    return under(
        title,
        number("position_error_mm", "position [mm]"),
        number("rotation_error_deg", "rotation [deg]"),
    )


SUITES = (
    ROBOT,
    SUITE,
    SOLVER,
    count("poses", "poses"),
    *_rate("success [%]", "success"),
    *_time("time [ms]"),
    *_nearest("mean error of the missed"),
)
TRUE_NO = (
    ROBOT,
    KIND,
    SOLVER,
    count("poses", "poses"),
    *_rate("true no [%]", "success"),
    count("claimed", "claims a solution"),
    *_time("time [ms]"),
    *_nearest("mean error of the answer"),
)
FOLLOWED = (
    ROBOT,
    number("rate_hz", "waypoints a second", digits=None),
    KIND,
    SOLVER,
    count("trajectories", "trajectories"),
    *_rate("followed [%]", "success"),
    share("in_period", "in time [%]", decimals=2),
    count("jumps", "jumps"),
    number("largest_step", "largest step [rad]"),
    *under(
        "path error, mean",
        number("position_error_mm", "position [mm]"),
        number("rotation_error_deg", "rotation [deg]"),
    ),
    number("drift", "drift [rad]"),
)
LEADERS = (
    ROBOT,
    SUITE,
    text("best", "best", convert=solver_title),
    *under("its rate [%]", share("best_share", "share"), share("best_low", "from")),
    text("second", "second", convert=solver_title),
    *under("its rate [%]", share("second_share", "share"), share("second_high", "to")),
    text("apart", "apart"),
)


def suites(rows: Rows, config: ReportConfig) -> Table:
    """Solver by suite and robot, for suites of poses that can be reached, one by one."""
    return Table.of(
        [
            {**names, **_success(part, config), **_times(part)}
            for names, part in _each(rows)
            if names["suite"] not in (UNREACHABLE, TRACKING)
        ],
        SUITES,
        name="suites",
        title="Suites of hard poses",
        caption=f"Success at {tolerance_title(config.success.strict)} (Euclidean, geodesic, joint "
        f"limits kept) with {config.confidence * 100:g} % Wilson intervals, time of a call with "
        "one pose, found or not, and the mean error of the answers to those that were missed.",
    )


def unreachable(rows: Rows, config: ReportConfig) -> Table:
    """Solver by kind of pose that cannot be reached: how often and how fast it says so."""
    return Table.of(
        [
            {**names, "stratum": kind, **_true_no(part, config), **_times(part)}
            for names, kind, part in _by(rows, UNREACHABLE, "stratum")
        ],
        TRUE_NO,
        name="suites_unreachable",
        title="Poses that cannot be reached",
        caption="A true no claims no solution; a claim is counted as one whatever the tolerance of "
        f"the solver. {config.confidence * 100:g} % Wilson intervals; time of a call with one "
        "pose; the error is that of the joints that came back, the nearest that were met.",
    )


def tracking(rows: Rows, config: ReportConfig) -> Table:
    """Solver by rate and kind of trajectory: whether it is followed, in time, without a jump."""
    return Table.of(
        [
            {**names, "rate_hz": rate, "stratum": kind, **_followed(part, config)}
            for names, (rate, kind), part in _by(rows, TRACKING, ["rate_hz", "stratum"])
        ],
        FOLLOWED,
        name="suites_tracking",
        title="Trajectories that a continuous solution is known to",
        caption=f"Followed: every waypoint at {tolerance_title(config.success.strict)}, and no "
        f"joint further than {JUMP:g} rad (m) from the answer before; "
        f"{config.confidence * 100:g} % Wilson intervals over trajectories. In time: waypoints "
        "solved within the period. Drift: mean distance of the last answer from the path that the "
        "trajectory was made of, the joint that is furthest off.",
    )


def leaders(rows: Rows, config: ReportConfig) -> Table:
    """The best and the second-best solver of each suite and robot, and whether they are apart."""
    lines = pd.DataFrame([{**names, **_leading(part, config)} for names, part in _each(rows)])
    found = []
    for (robot, suite), group in (
        lines.groupby(["robot", "suite"], sort=False) if len(lines) else ()
    ):
        if len(group) < 2:
            continue
        ranked = group.sort_values("success_share", ascending=False, kind="stable")
        best, second = ranked.iloc[0], ranked.iloc[1]
        found.append(
            {
                "robot": robot,
                "suite": suite,
                "best": best.solver,
                "best_share": best.success_share,
                "best_low": best.success_low,
                "second": second.solver,
                "second_share": second.success_share,
                "second_high": second.success_high,
                "apart": "yes" if best.success_low > second.success_high else "no",
            }
        )
    return Table.of(
        found,
        LEADERS,
        name="suite_leaders",
        title="Who leads in each suite, and whether that is certain",
        caption="Rates are success, true no (unreachable) and trajectories followed (tracking). "
        f"Apart: the {config.confidence * 100:g} % Wilson intervals do not overlap.",
    )


def _each(rows: Rows) -> Iterator[tuple[dict[str, str], pd.DataFrame]]:
    """Rows of each robot, suite and solver, in the order that all tables share."""
    for robot in ordered_robots({robot for robot, _, _ in rows}):
        for suite in sorted({suite for name, suite, _ in rows if name == robot}):
            solvers = {solver for name, of, solver in rows if (name, of) == (robot, suite)}
            for solver in ordered_solvers(solvers):
                names = {"robot": robot, "suite": suite, "solver": solver}
                yield names, rows[robot, suite, solver]


def _by(
    rows: Rows, suite: str, column: str | list[str]
) -> Iterator[tuple[dict[str, str], Any, pd.DataFrame]]:
    """Rows of one suite, parted by columns: robot by robot, part by part, solver by solver."""
    parts = [
        (names, kind, part)
        for names, whole in _each(rows)
        if names["suite"] == suite
        for kind, part in whole.groupby(column, sort=False)
    ]
    for robot in dict.fromkeys(names["robot"] for names, _, _ in parts):
        mine = [part for part in parts if part[0]["robot"] == robot]
        for kind in dict.fromkeys(kind for _, kind, _ in mine):
            yield from (part for part in mine if part[1] == kind)


def _leading(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    suite = rows.suite.iloc[0]
    if suite == UNREACHABLE:
        return _true_no(rows, config)
    return _followed(rows, config) if suite == TRACKING else _success(rows, config)


def _success(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    solved = _solved(rows, config)
    return {**_interval(solved, config), **_errors(rows[~solved])}


def _true_no(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    claimed = rows.found.to_numpy(dtype=bool)
    return {**_interval(~claimed, config), "claimed": int(claimed.sum()), **_errors(rows)}


def _followed(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    jumped = (rows.joint_step > JUMP).to_numpy()
    timeless = bool(rows.time_per_pose_us.isna().any())
    late = rows.time_per_pose_us.to_numpy() > US_PER_S / rows.rate_hz.to_numpy()
    solved = _solved(rows, config)
    key = [rows.trajectory.to_numpy(), rows.rate_hz.to_numpy()]
    followed = pd.Series(solved & ~jumped).groupby(key).all().to_numpy(dtype=bool)
    last = rows.groupby(["trajectory", "rate_hz"]).step.idxmax()
    return {
        **_interval(followed, config),
        **_errors(rows),
        "trajectories": len(followed),
        "in_period": None if timeless else float((solved & ~late).mean()),
        "jumps": int(jumped.sum()),
        "largest_step": float(rows.joint_step.max()),
        "drift": float(rows.known_distance[last].mean()),
    }


def _solved(rows: pd.DataFrame, config: ReportConfig) -> Flags:
    """(N,) which poses count as reached, as in every other table."""
    counted = apply_not_found(rows, config.not_found)
    return np.asarray(successes(counted, "geodesic", config.success.strict))


def _interval(good: Flags, config: ReportConfig) -> dict[str, Any]:
    interval = wilson_interval(int(good.sum()), len(good), config.confidence)
    return {
        "poses": len(good),
        "success_share": interval.estimate,
        "success_low": interval.low,
        "success_high": interval.high,
    }


def _errors(rows: pd.DataFrame) -> dict[str, float | None]:
    """Mean errors of the joints that came back; none where there are no rows."""
    names = ("position_error_mm", "rotation_error_deg")
    return {name: float(rows[name].mean()) if len(rows) else None for name in names}


def _times(rows: pd.DataFrame) -> dict[str, float]:
    times = rows.time_per_pose_us.to_numpy(dtype=float) / US_PER_MS
    return {
        "time_median_ms": float(np.median(times)),
        "time_p99_ms": float(np.quantile(times, 0.99)),
    }


TOPIC = Topic(
    stages=("evaluate_suite", "judge"),
    tables=(
        lambda data: suites(data.results.suites, data.config),
        lambda data: unreachable(data.results.suites, data.config),
        lambda data: tracking(data.results.suites, data.config),
        lambda data: leaders(data.results.suites, data.config),
    ),
)
