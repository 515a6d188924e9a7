"""From raw rows to numbers: one line per robot, solver and batch size. Pure functions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.evaluation.config import Tolerance
from pipeline.evaluation.metrics import within
from pipeline.evaluation.statistics import bootstrap_interval, wilson_interval
from pipeline.presentation.naming import ordered_robots, ordered_solvers
from pipeline.reporting.config import ReportConfig

ERRORS = (
    "position_error_mm",
    "rotation_error_deg",
    "paper_position_error_mm",
    "paper_rotation_error_deg",
)
INTERVALS = ("position_error_mm", "rotation_error_deg")


def apply_not_found(rows: pd.DataFrame, policy: str) -> pd.DataFrame:
    """Put in place what a pose without an answer counts; answers keep their own errors.

    Args:
        rows: Raw rows of the evaluate stage.
        policy: ``idle`` for the errors of the idle configuration (the paper), ``nan`` for none.

    Returns:
        The rows with the four error columns replaced where ``answered`` is false.
    """
    answered = rows.answered.to_numpy(dtype=bool)
    replaced = {}
    for name in ERRORS:
        if policy == "idle":
            paper = "paper_" if name.startswith("paper_") else ""
            other = rows[f"{paper}idle_{name.removeprefix('paper_')}"].to_numpy(dtype=float)
        else:
            other = np.full(len(rows), np.nan)
        replaced[name] = np.where(answered, rows[name].to_numpy(dtype=float), other)
    return rows.assign(**replaced)


def successes(rows: pd.DataFrame, family: str, tolerance: Tolerance) -> NDArray[np.bool_]:
    """Tell which rows reached their pose.

    Args:
        rows: Rows after `apply_not_found`.
        family: ``geodesic``, where joint limits must be kept too, or ``paper``, which does not ask.
        tolerance: What counts as reached.

    Returns:
        (N,) flags; a row without an error never succeeds.
    """
    prefix = "paper_" if family == "paper" else ""
    reached = within(
        rows[f"{prefix}position_error_mm"],
        rows[f"{prefix}rotation_error_deg"],
        tolerance.position_mm,
        tolerance.rotation_deg,
    )
    return reached if family == "paper" else reached & rows.within_limits.to_numpy(dtype=bool)


def summarise(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """Summarise raw rows, one line per robot, solver and batch size.

    The line with most poses of a robot and solver has ``main`` set: errors are read off there, the
    others are for time.

    Args:
        rows: Raw rows of the evaluate stage, of any number of robots and solvers.
        config: Not-found policy, success, confidence.

    Returns:
        The summary; errors in mm and deg, rates as shares, times in us and ms as named.
    """
    counted = apply_not_found(rows, config.not_found)
    lines = []
    for (robot, solver), group in counted.groupby(["robot", "solver"], sort=False):
        main = main_batch(group)
        for batch_size, part in group.groupby("batch_size", sort=True):
            line = {"robot": robot, "solver": solver, "batch_size": batch_size}
            line["main"] = batch_size == main
            lines.append({**line, **_numbers(part, config, bool(line["main"]))})
    return pd.DataFrame(lines)


def main_batch(rows: pd.DataFrame) -> int:
    """Return the batch size that answered most poses, the smallest of equals."""
    counts = rows.groupby("batch_size").pose.nunique()
    return int(counts[counts == counts.max()].index.min())


def counted(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """Return the rows that errors are read off, with what a pose without an answer counts."""
    main = rows[rows.batch_size == main_batch(rows)]
    return apply_not_found(main, config.not_found)


def in_order(lines: pd.DataFrame) -> pd.DataFrame:
    """Sort lines by robot, solver and batch size, in the order that all tables share."""
    if lines.empty:
        return lines
    robots, solvers = ordered_robots(lines.robot), ordered_solvers(lines.solver)
    places = lines.assign(
        robot=lines.robot.map(robots.index), solver=lines.solver.map(solvers.index)
    )
    return lines.loc[places.sort_values(["robot", "solver", "batch_size"]).index]


def _numbers(rows: pd.DataFrame, config: ReportConfig, main: bool) -> dict[str, Any]:
    """One line of the summary; intervals by bootstrap only where errors are read off."""
    numbers: dict[str, Any] = {
        "poses": rows.pose.nunique(),
        "seeds": rows.seed.nunique(),
        "answered": rows.answered.mean(),
        "found": rows.found.mean(),
        "claimed_and_wrong": int(rows.claimed_and_wrong.sum()),
        "outside_limits": int((~rows.within_limits).sum()),
    }
    for name in ERRORS:
        numbers |= _spread(rows[name].to_numpy(dtype=float), name)
    for name in INTERVALS if main else ():
        numbers |= _intervals(rows, name, config)
    numbers |= _rates(rows, config) | _times(rows)
    numbers |= {name: rows[name].iloc[0] for name in ("threads", "pinned", "machine")}
    return numbers


def _intervals(rows: pd.DataFrame, name: str, config: ReportConfig) -> dict[str, float]:
    """Bootstrap intervals of a mean, over poses and, apart from it, over training seeds.

    Over poses: how far another test set would move the mean of these very networks; a pose counts
    once, with its mean over the seeds. Over seeds: how far other trainings would. One training says
    nothing of the second, which is NaN then.
    """
    numbers: dict[str, float] = {}
    for unit, key in (("", "pose"), ("_seeds", "seed")):
        means = rows[name] if key == "pose" and rows.seed.nunique() == 1 else None
        means = rows.groupby(key)[name].mean() if means is None else means
        if key == "seed" and len(means) == 1:
            means = means.iloc[:0]
        interval = bootstrap_interval(
            means, np.mean, config.confidence, config.resamples, config.seed
        )
        numbers |= {
            f"{name}_mean{unit}_low": interval.low,
            f"{name}_mean{unit}_high": interval.high,
        }
    return numbers


def _spread(values: NDArray[np.float64], name: str) -> dict[str, float]:
    counted = values[~np.isnan(values)]
    if counted.size == 0:
        counted = np.array([np.nan])
    median, p90, p99 = np.quantile(counted, [0.5, 0.9, 0.99])
    return {
        f"{name}_mean": float(counted.mean()),
        f"{name}_sd": float(counted.std()),
        f"{name}_median": float(median),
        f"{name}_p90": float(p90),
        f"{name}_p99": float(p99),
    }


def _rates(rows: pd.DataFrame, config: ReportConfig) -> dict[str, float]:
    rates = {}
    seeds = rows.seed.nunique()
    for name in ("strict", "loose", "paper"):
        family = "paper" if name == "paper" else "geodesic"
        reached = successes(rows, family, getattr(config.success, name))
        # Several trainings on the same poses are no more poses than there are.
        interval = wilson_interval(
            round(reached.sum() / seeds), round(len(rows) / seeds), config.confidence
        )
        rates[f"success_{name}"] = float(reached.mean())
        rates[f"success_{name}_low"] = interval.low
        rates[f"success_{name}_high"] = interval.high
    return rates


def _times(rows: pd.DataFrame) -> dict[str, float]:
    times = rows.time_per_pose_us.to_numpy(dtype=float)
    batch_size = int(rows.batch_size.iloc[0])
    return {
        "calls": -(-len(rows) // batch_size),
        "time_per_pose_mean_us": float(times.mean()),
        "time_per_pose_median_us": float(np.median(times)),
        "time_per_pose_p99_us": float(np.quantile(times, 0.99)),
        "time_per_batch_mean_ms": float(times.mean() * batch_size / 1e3),
        "solver_time_median_us": float(rows.solver_time_us.median()),
        "iterations_mean": float(rows.iterations.mean()),
    }
