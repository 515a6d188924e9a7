"""Solvers on suites of hard poses: success, time, what a miss costs, and who is clearly better."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pandas as pd

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
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig, tolerance_title
from pipeline.reporting.data import ReportData, Topic
from pipeline.reporting.suite_leaders import SUITE, leaders, quickest
from pipeline.reporting.suite_measures import (
    JUMP,
    QUICK,
    Rows,
    counts,
    each_solver,
    errors,
    followed_trajectories,
    free_of_collision,
    generator_of,
    good_poses,
    quick_calls,
    solved_poses,
    times,
)
from pipeline.suites.config import CLUTTERED, PARTIAL, TRACKING, UNREACHABLE
from pipeline.suites.verdicts import TOLERANCE_MM, disagreements, free_by_coal

US_PER_S = 1e6

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
    text("solved_as", "requested"),
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
    text("obstacles_given", "obstacles given"),
    count("poses", "poses"),
    share("reached_share", "reached [%]"),
    *_rate("reached and free [%]", "success"),
    count("own", "in self-collision"),
    count("false_claims", "claimed, not free"),
    count("disagreements", "judges differ"),
    *_time("time [ms]"),
)


def suites(rows: Rows, config: ReportConfig) -> Table:
    """Solver by suite and robot, for suites of poses that can be reached, one by one."""
    return Table.of(
        [
            {**names, **_success(part, config), **times(part)}
            for names, part in each_solver(rows)
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
            {**names, "stratum": kind, **_true_no(part, config), **times(part)}
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
            {**names, "stratum": kind, **_requested(part), **_success(part, config), **times(part)}
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
            {**names, "stratum": kind, **_avoided(part, config), **times(part)}
            for names, kind, part in _by(rows, CLUTTERED, "stratum")
        ],
        AMONG_OBSTACLES,
        name="suites_cluttered",
        title="Poses among obstacles that a free solution is known to",
        caption="Kind: the clearance that the known configuration keeps; a share of it is "
        "requested (suite.requested). Reached as in the other suites; free: no self-collision and "
        "that clearance kept, by coal and by PyBullet. Solvers that know nothing of collisions are "
        "not given the obstacles. Claimed, not free: by a solver that was, judged by coal. "
        f"Judges differ: by more than {TOLERANCE_MM:g} mm. {config.confidence * 100:g} % Wilson "
        "intervals.",
    )


def _by(
    rows: Rows, generator: str, column: str | list[str]
) -> Iterator[tuple[dict[str, str], Any, pd.DataFrame]]:
    """Rows of suites of one generator, parted by columns: by robot, by part, by solver."""
    parts = [
        (names, kind, part)
        for names, whole in each_solver(rows)
        if generator_of(whole) == generator
        for kind, part in whole.groupby(column, sort=False)
    ]
    for robot in dict.fromkeys(names["robot"] for names, _, _ in parts):
        mine = [part for part in parts if part[0]["robot"] == robot]
        for kind in dict.fromkeys(kind for _, kind, _ in mine):
            yield from (part for part in mine if part[1] == kind)


def _success(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    solved, quick = solved_poses(rows, config), quick_calls(rows)
    sooner = {} if quick is None else counts(solved & quick, config, "quick")
    nothing = dict.fromkeys(("quick_share", "quick_low", "quick_high"))
    return {**counts(solved, config), **nothing, **sooner, **errors(rows[~solved])}


def _true_no(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    claimed = rows.found.to_numpy(dtype=bool)
    right = float(rows.explained_right.mean()) if "explained_right" in rows else None
    said = {"claimed": int(claimed.sum()), "explained_share": right}
    return {**counts(good_poses(rows, config), config), **said, **errors(rows)}


def _requested(rows: pd.DataFrame) -> dict[str, str | None]:
    """What was requested of the solver; nobody knows of answers from elsewhere."""
    return {"solved_as": str(rows.solved_as.iloc[0]) if "solved_as" in rows else None}


def _avoided(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    solved, given = solved_poses(rows, config), bool(rows.obstacles_given.all())
    claimed = rows.found.to_numpy(dtype=bool) & given
    return {
        **counts(solved & free_of_collision(rows), config),
        "obstacles_given": "yes" if given else "no",
        "reached_share": float(solved.mean()),
        "own": int(rows.self_collision.sum()),
        "false_claims": int((claimed & ~free_by_coal(rows)).sum()),
        "disagreements": int(disagreements(rows).sum()),
    }


def _followed(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Any]:
    timeless = bool(rows.time_per_pose_us.isna().any())
    late = rows.time_per_pose_us.to_numpy() > US_PER_S / rows.rate_hz.to_numpy()
    solved, followed = solved_poses(rows, config), followed_trajectories(rows, config)
    last = rows.groupby(["trajectory", "rate_hz"]).step.idxmax()
    return {
        **counts(followed, config),
        **errors(rows),
        "trajectories": len(followed),
        "in_period": None if timeless else float((solved & ~late).mean()),
        "jumps": int((rows.joint_step > JUMP).sum()),
        "largest_step": float(rows.joint_step.max()),
        "drift": float(rows.known_distance[last].mean()),
    }


def _of_data(make: Callable[[Rows, ReportConfig], Table]) -> Callable[[ReportData], Table]:
    return lambda data: make(data.results.suites, data.config)


TABLES = (suites, unreachable, partial, tracking, cluttered, leaders, quickest)
TOPIC = Topic(stages=("evaluate_suite", "judge"), tables=tuple(map(_of_data, TABLES)))
