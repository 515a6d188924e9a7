"""What the rows of a suite say of a solver: rates, times, errors of the missed."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.evaluation.statistics import (
    Interval,
    bootstrap_interval,
    shifted_geometric_mean,
    wilson_interval,
)
from pipeline.presentation.naming import ordered_robots, ordered_solvers
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.summary import apply_not_found, successes
from pipeline.suites.config import CLUTTERED, TRACKING, UNREACHABLE
from pipeline.suites.judging import NO_ANSWER, NOT_FINITE
from pipeline.suites.verdicts import free_by_bullet, free_by_coal

Rows = Mapping[tuple[str, str, str], pd.DataFrame]
Flags = NDArray[np.bool_]

QUICK_MS = 0.1  # where all succeed in the end, who does so within this time tells them apart
QUICK = f"within {QUICK_MS:g} ms"
JUMP = 0.1  # rad or m from one waypoint to the next that no trajectory asks for
US_PER_MS = 1e3
SUCCESS = "success"
NO_WORD = (NO_ANSWER, NOT_FINITE)  # reasons of rows that say neither yes nor no
RATES = {  # how the share of good trials is called, by generator; of others: SUCCESS
    UNREACHABLE: "true no",
    TRACKING: "followed",
    CLUTTERED: "reached and free",
}


def each_solver(rows: Rows) -> Iterator[tuple[dict[str, str], pd.DataFrame]]:
    """Give the rows of each robot, suite and solver, in the order that all tables share."""
    for robot in ordered_robots({robot for robot, _, _ in rows}):
        for suite in sorted({suite for name, suite, _ in rows if name == robot}):
            solvers = {solver for name, of, solver in rows if (name, of) == (robot, suite)}
            for solver in ordered_solvers(solvers):
                names = {"robot": robot, "suite": suite, "solver": solver}
                yield names, rows[robot, suite, solver]


def rates(rows: pd.DataFrame, config: ReportConfig) -> dict[str, Interval]:
    """Return the rates by which solvers are ranked in a suite, the first of them first."""
    name, good = RATES.get(generator_of(rows), SUCCESS), good_trials(rows, config)
    found = {name: interval(good, config)}
    if name == SUCCESS and (quick := quick_calls(rows)) is not None:
        found[QUICK] = interval(good & quick, config)
    return found


def good_trials(rows: pd.DataFrame, config: ReportConfig) -> Flags:
    """Which trials meet the criterion of their suite: trajectories of tracking, poses of others."""
    tracks = generator_of(rows) == TRACKING
    return followed_trajectories(rows, config) if tracks else good_poses(rows, config)


def good_poses(rows: pd.DataFrame, config: ReportConfig) -> Flags:
    """(N,) which poses are solved; without a collision among obstacles, denied out of reach.

    Silence is no denial, nor is a claim whose joints are not finite.
    """
    if generator_of(rows) == UNREACHABLE:
        return np.asarray(~rows.found.to_numpy(dtype=bool) & ~rows.reason.isin(NO_WORD))
    solved = solved_poses(rows, config)
    return solved & free_of_collision(rows) if generator_of(rows) == CLUTTERED else solved


def mean_time_us(rows: pd.DataFrame, config: ReportConfig) -> Interval | None:
    """Return the shifted geometric mean of the time of a call, misses as long as they took.

    Its interval is a bootstrap over the poses of the suite: it says how far the mean is settled on
    this machine in this run. None where no time of a call is known.
    """
    times = call_ms(rows)
    if times is None:
        return None
    mean = partial(shifted_geometric_mean, shift=config.leaderboard.shift_us)
    return bootstrap_interval(
        US_PER_MS * times, mean, config.confidence, config.resamples, config.seed
    )


def generator_of(rows: pd.DataFrame) -> str:
    """Return what is in the suite that rows answer, see `pipeline.suites.generators`."""
    return str(rows.suite_generator.iloc[0])


def call_ms(rows: pd.DataFrame) -> NDArray[np.float64] | None:
    """(N,) time of a call with one pose; None for rows without times and of larger batches."""
    times = rows.time_per_pose_us.to_numpy(dtype=float) / US_PER_MS
    return None if np.isnan(times).any() or (rows.batch_size > 1).any() else times


def quick_calls(rows: pd.DataFrame) -> Flags | None:
    """(N,) which calls took no longer than `QUICK_MS`; None where no time of a call is known."""
    times = call_ms(rows)
    return None if times is None else times <= QUICK_MS


def free_of_collision(rows: pd.DataFrame) -> Flags:
    """(N,) which answers both judges find free of collision."""
    return free_by_coal(rows) & free_by_bullet(rows)


def followed_trajectories(rows: pd.DataFrame, config: ReportConfig) -> Flags:
    """Which trajectories have every waypoint solved and no jump, one flag a trajectory and rate."""
    good = solved_poses(rows, config) & ~(rows.joint_step > JUMP).to_numpy()
    key = [rows.trajectory.to_numpy(), rows.rate_hz.to_numpy()]
    return np.asarray(pd.Series(good).groupby(key).all().to_numpy(dtype=bool))


def solved_poses(rows: pd.DataFrame, config: ReportConfig) -> Flags:
    """(N,) which poses count as reached, as in every other table."""
    counted = apply_not_found(rows, config.not_found)
    return np.asarray(successes(counted, "geodesic", config.success.strict))


def interval(good: Flags, config: ReportConfig) -> Interval:
    """Return the share of flags that are set, with its Wilson interval."""
    return wilson_interval(int(good.sum()), len(good), config.confidence)


def counts(good: Flags, config: ReportConfig, name: str = "success") -> dict[str, Any]:
    """Return `interval` as cells of a table, with the number of poses."""
    found = interval(good, config)
    return {
        "poses": len(good),
        f"{name}_share": found.estimate,
        f"{name}_low": found.low,
        f"{name}_high": found.high,
    }


def errors(rows: pd.DataFrame) -> dict[str, float | None]:
    """Return mean errors of the joints that came back; none where there are no rows."""
    names = ("position_error_mm", "rotation_error_deg")
    return {name: float(rows[name].mean()) if len(rows) else None for name in names}


def times(rows: pd.DataFrame) -> dict[str, float | None]:
    """Return median and 99th percentile of the time of a call, none where it is not known."""
    calls = call_ms(rows)
    if calls is None:
        return {"time_median_ms": None, "time_p99_ms": None}
    return {
        "time_median_ms": float(np.median(calls)),
        "time_p99_ms": float(np.quantile(calls, 0.99)),
    }
