"""Solvers on suites of hard poses: success, time, what a miss costs, and who is clearly better."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.evaluation.statistics import Interval, wilson_interval
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
from pipeline.suites.config import CLUTTERED, PARTIAL, TRACKING, UNREACHABLE
from pipeline.suites.verdicts import TOLERANCE_MM, disagreements, free_by_bullet, free_by_coal

Rows = Mapping[tuple[str, str, str], pd.DataFrame]
Flags = NDArray[np.bool_]

QUICK_MS = 0.1  # where all succeed in the end, who does so within this time tells them apart
QUICK = f"within {QUICK_MS:g} ms"
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
    *_rate(f"{QUICK} [%]", "quick"),
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
    share("explained_share", "reason right [%]"),
    *_time("time [ms]"),
    *_nearest("mean error of the answer"),
)
FREED = (
    ROBOT,
    KIND,
    SOLVER,
    text("solved_as", "asked for"),
    count("poses", "poses"),
    *_rate("success [%]", "success"),
    *_time("time [ms]"),
    *_nearest("mean error of the missed"),
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
AMONG_OBSTACLES = (
    ROBOT,
    KIND,
    SOLVER,
    text("asked", "told the obstacles"),
    count("poses", "poses"),
    share("reached_share", "reached [%]"),
    *_rate("reached and free [%]", "success"),
    count("own", "in self-collision"),
    count("false_claims", "claimed, not free"),
    count("disagreements", "judges differ"),
    *_time("time [ms]"),
)
LEADERS = (
    ROBOT,
    SUITE,
    text("rate", "rate"),
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
            if generator_of(part) not in (UNREACHABLE, TRACKING, PARTIAL, CLUTTERED)
        ],
        SUITES,
        name="suites",
        title="Suites of hard poses",
        caption=f"Success at {tolerance_title(config.success.strict)} (Euclidean, geodesic, joint "
        f"limits kept) with {config.confidence * 100:g} % Wilson intervals, time of a call with "
        "one pose, found or not (none for a solver that was given batches), and the mean error of "
        "the answers to those that were missed.",
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
        "pose; the error is that of the joints that came back, the nearest that were met. Reason "
        "right: what a solver that explains its no says of it, where what is true is known.",
    )


def partial(rows: Rows, config: ReportConfig) -> Table:
    """Solver by what a target leaves open: how often it is reached under just these freedoms."""
    return Table.of(
        [
            {**names, "stratum": kind, **_asked(part), **_success(part, config), **_times(part)}
            for names, kind, part in _by(rows, PARTIAL, "stratum")
        ],
        FREED,
        name="suites_partial",
        title="Targets of which a part is free",
        caption=f"Success at {tolerance_title(config.success.strict)} under the freedoms of the "
        "target: errors are those to the nearest pose that it allows, whatever the solver was "
        "asked for. A solver of whole poses was asked for one of them, with a random value in "
        f"place of what is free. {config.confidence * 100:g} % Wilson intervals.",
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


def cluttered(rows: Rows, config: ReportConfig) -> Table:
    """Solver by clearance: how often a pose among obstacles is reached free of collision."""
    return Table.of(
        [
            {**names, "stratum": kind, **_avoided(part, config), **_times(part)}
            for names, kind, part in _by(rows, CLUTTERED, "stratum")
        ],
        AMONG_OBSTACLES,
        name="suites_cluttered",
        title="Poses among obstacles that a free solution is known to",
        caption="Kind: the clearance that the known configuration keeps; a share of it is asked "
        "(suite.asked). Reached as in the other suites; free: no self-collision and the asked "
        "clearance kept, by coal and by PyBullet. Solvers that know nothing of collisions are "
        "not told the obstacles. Claimed, not free: by a solver that was told, judged by coal. "
        f"Judges differ: by more than {TOLERANCE_MM:g} mm. {config.confidence * 100:g} % Wilson "
        "intervals.",
    )


def leaders(rows: Rows, config: ReportConfig) -> Table:
    """The best and the second-best solver of each suite and robot, and whether they are apart."""
    ranked: dict[tuple[str, str, str], list[tuple[str, Interval]]] = {}
    for names, part in _each(rows):
        for rate, interval in rates(part, config).items():
            key = (names["robot"], names["suite"], rate)
            ranked.setdefault(key, []).append((names["solver"], interval))
    found = []
    for (robot, suite, rate), group in ranked.items():
        if len(group) < 2:
            continue
        (best, first), (second, other) = sorted(group, key=lambda each: -each[1].estimate)[:2]
        found.append(
            {
                "robot": robot,
                "suite": suite,
                "rate": rate,
                "best": best,
                "best_share": first.estimate,
                "best_low": first.low,
                "second": second,
                "second_share": other.estimate,
                "second_high": other.high,
                "apart": "yes" if first.low > other.high else "no",
            }
        )
    return Table.of(
        found,
        LEADERS,
        name="suite_leaders",
        title="Who leads in each suite, and whether that is certain",
        caption=f"Rates are success, success {QUICK}, true no (unreachable; who always says no has "
        "all of these), trajectories followed (tracking), and poses reached free of collision "
        "(cluttered). "
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
    rows: Rows, generator: str, column: str | list[str]
) -> Iterator[tuple[dict[str, str], Any, pd.DataFrame]]:
    """Rows of suites of one generator, parted by columns: by robot, by part, by solver."""
    parts = [
        (names, kind, part)
        for names, whole in _each(rows)
        if generator_of(whole) == generator
        for kind, part in whole.groupby(column, sort=False)
    ]
    for robot in dict.fromkeys(names["robot"] for names, _, _ in parts):
        mine = [part for part in parts if part[0]["robot"] == robot]
        for kind in dict.fromkeys(kind for _, kind, _ in mine):
            yield from (part for part in mine if part[1] == kind)


def rates(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Interval]:
    """The rates by which solvers are ranked in a suite."""
    generator, solved = generator_of(rows), solved_poses(rows, config)
    if generator == UNREACHABLE:
        return {"true no": _interval(~rows.found.to_numpy(dtype=bool), config)}
    if generator == TRACKING:
        return {"followed": _interval(followed_trajectories(rows, config), config)}
    if generator == CLUTTERED:
        return {"reached and free": _interval(solved & _free(rows), config)}
    found = {"success": _interval(solved, config)}
    if (quick := _quick(rows)) is not None:
        found[QUICK] = _interval(solved & quick, config)
    return found


def generator_of(rows: pd.DataFrame) -> str:
    """Return what is in the suite that rows answer, see `pipeline.suites.generators`."""
    return str(rows.suite_generator.iloc[0])


def _call_ms(rows: pd.DataFrame) -> NDArray[np.float64] | None:
    """(N,) time of a call with one pose; None for rows without times and of larger batches."""
    times = rows.time_per_pose_us.to_numpy(dtype=float) / US_PER_MS
    return None if np.isnan(times).any() or (rows.batch_size > 1).any() else times


def _quick(rows: pd.DataFrame) -> Flags | None:
    """(N,) which calls took no longer than `QUICK_MS`; None where no time of a call is known."""
    times = _call_ms(rows)
    return None if times is None else times <= QUICK_MS


def _success(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    solved, quick = solved_poses(rows, config), _quick(rows)
    sooner = {} if quick is None else _counts(solved & quick, config, "quick")
    nothing = dict.fromkeys(("quick_share", "quick_low", "quick_high"))
    return {**_counts(solved, config), **nothing, **sooner, **_errors(rows[~solved])}


def _true_no(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    claimed = rows.found.to_numpy(dtype=bool)
    right = float(rows.explained_right.mean()) if "explained_right" in rows else None
    said = {"claimed": int(claimed.sum()), "explained_share": right}
    return {**_counts(~claimed, config), **said, **_errors(rows)}


def _asked(rows: pd.DataFrame) -> dict[str, str | None]:
    """What the solver was asked for; nobody knows of answers from elsewhere."""
    return {"solved_as": str(rows.solved_as.iloc[0]) if "solved_as" in rows else None}


def _avoided(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    solved, asked = solved_poses(rows, config), bool(rows.asked.all())
    claimed = rows.found.to_numpy(dtype=bool) & asked
    return {
        **_counts(solved & _free(rows), config),
        "asked": "yes" if asked else "no",
        "reached_share": float(solved.mean()),
        "own": int(rows.self_collision.sum()),
        "false_claims": int((claimed & ~free_by_coal(rows)).sum()),
        "disagreements": int(disagreements(rows).sum()),
    }


def _free(rows: pd.DataFrame) -> Flags:
    """(N,) which answers both judges find free of collision."""
    return free_by_coal(rows) & free_by_bullet(rows)


def _followed(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    timeless = bool(rows.time_per_pose_us.isna().any())
    late = rows.time_per_pose_us.to_numpy() > US_PER_S / rows.rate_hz.to_numpy()
    solved, followed = solved_poses(rows, config), followed_trajectories(rows, config)
    last = rows.groupby(["trajectory", "rate_hz"]).step.idxmax()
    return {
        **_counts(followed, config),
        **_errors(rows),
        "trajectories": len(followed),
        "in_period": None if timeless else float((solved & ~late).mean()),
        "jumps": int((rows.joint_step > JUMP).sum()),
        "largest_step": float(rows.joint_step.max()),
        "drift": float(rows.known_distance[last].mean()),
    }


def followed_trajectories(rows: pd.DataFrame, config: ReportConfig) -> Flags:
    """Which trajectories have every waypoint solved and no jump, one flag a trajectory and rate."""
    good = solved_poses(rows, config) & ~(rows.joint_step > JUMP).to_numpy()
    key = [rows.trajectory.to_numpy(), rows.rate_hz.to_numpy()]
    return np.asarray(pd.Series(good).groupby(key).all().to_numpy(dtype=bool))


def solved_poses(rows: pd.DataFrame, config: ReportConfig) -> Flags:
    """(N,) which poses count as reached, as in every other table."""
    counted = apply_not_found(rows, config.not_found)
    return np.asarray(successes(counted, "geodesic", config.success.strict))


def _interval(good: Flags, config: ReportConfig) -> Interval:
    return wilson_interval(int(good.sum()), len(good), config.confidence)


def _counts(good: Flags, config: ReportConfig, name: str = "success") -> dict[str, Any]:
    interval = _interval(good, config)
    return {
        "poses": len(good),
        f"{name}_share": interval.estimate,
        f"{name}_low": interval.low,
        f"{name}_high": interval.high,
    }


def _errors(rows: pd.DataFrame) -> dict[str, float | None]:
    """Mean errors of the joints that came back; none where there are no rows."""
    names = ("position_error_mm", "rotation_error_deg")
    return {name: float(rows[name].mean()) if len(rows) else None for name in names}


def _times(rows: pd.DataFrame) -> dict[str, float | None]:
    times = _call_ms(rows)
    if times is None:
        return {"time_median_ms": None, "time_p99_ms": None}
    return {
        "time_median_ms": float(np.median(times)),
        "time_p99_ms": float(np.quantile(times, 0.99)),
    }


TOPIC = Topic(
    stages=("evaluate_suite", "judge"),
    tables=(
        lambda data: suites(data.results.suites, data.config),
        lambda data: unreachable(data.results.suites, data.config),
        lambda data: partial(data.results.suites, data.config),
        lambda data: tracking(data.results.suites, data.config),
        lambda data: cluttered(data.results.suites, data.config),
        lambda data: leaders(data.results.suites, data.config),
    ),
)
