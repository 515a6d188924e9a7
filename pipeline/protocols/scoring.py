"""What a protocol makes of raw rows: rates, errors and times, by its own rules. Pure functions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.evaluation.metrics import within
from pipeline.protocols.config import HIGHER_IS_BETTER, NO_SUCCESS, ProtocolConfig

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

PREFIX = {"axes_mean": "paper_", "euclidean": "", "each_axis": "axis_"}  # of columns of rows
US_PER_MS = 1e3
SHIFT = 1.0  # mm, deg or ms: what the shifted geometric mean adds before it takes logarithms


@dataclass(frozen=True)
class Score:
    """What one protocol reports of one solver.

    Attributes:
        targets: How many were asked.
        success: Share of them; NaN where nothing counts as success.
        position: Error by the protocol's statistic [mm]; NaN where no pose counts.
        rotation: Likewise [deg].
        time: Of a call, by the protocol's statistic [ms].
    """

    targets: int
    success: float
    position: float
    rotation: float
    time: float


def score(rows: pd.DataFrame, protocol: ProtocolConfig) -> Score:
    """Score the rows of one solver and one batch size.

    Args:
        rows: Raw rows with the columns of `pipeline.protocols.problems`.
        protocol: Whose rules; those of another one than the rows were made for serve as well.
    """
    chosen = _nearest_draws(rows, protocol) if protocol.best_draw else rows
    reached = _successes(chosen, protocol)
    counts = reached if protocol.errors.of == "successes" else np.ones(len(chosen), dtype=bool)
    position, rotation = _errors(chosen, protocol.errors.kind, protocol.errors.not_found)
    calls = rows.time_per_pose_us.groupby(rows.call).sum().to_numpy(dtype=float) / US_PER_MS
    named = protocol.success.errors != NO_SUCCESS
    return Score(
        targets=int(rows.target.nunique()),
        success=float(reached.mean()) if named else float("nan"),
        position=statistic(position[counts], protocol.errors.statistic),
        rotation=statistic(rotation[counts], protocol.errors.statistic),
        time=statistic(calls, protocol.time_statistic),
    )


def statistic(values: Array, name: str) -> float:
    """Return a statistic of values; NaN where there are none.

    Args:
        values: (N,) none of them negative.
        name: ``mean``, ``median``, ``p98`` (98th percentile, linear between ranks), or
            ``shifted_mean``, the geometric mean of the values plus one unit, minus that.
    """
    if len(values) == 0:
        return float("nan")
    if name == "mean":
        return float(np.mean(values))
    if name == "shifted_mean":
        return float(np.exp(np.mean(np.log(values + SHIFT))) - SHIFT)
    return float(np.quantile(values, 0.5 if name == "median" else 0.98))


def ranks(scores: dict[str, Score], protocol: ProtocolConfig) -> dict[str, int]:
    """Rank solvers: 1 is the best, those that share the protocol's digits share a rank.

    The rank is one more than the number of solvers that are better; who has no value comes last.

    Args:
        scores: By solver.
        protocol: What it ranks by, and in how many digits.
    """
    by = protocol.rank.by
    sign = -1.0 if HIGHER_IS_BETTER[by] else 1.0
    values = {
        name: sign * rounded(getattr(each, by), protocol.rank.digits)
        for name, each in scores.items()
    }
    values = {name: np.inf if np.isnan(value) else value for name, value in values.items()}
    return {name: 1 + sum(v < value for v in values.values()) for name, value in values.items()}


def rounded(value: float, digits: int) -> float:
    """Return a number with so many significant digits."""
    return float(f"{value:.{digits - 1}e}")


def _nearest_draws(rows: pd.DataFrame, protocol: ProtocolConfig) -> pd.DataFrame:
    """Of the draws of each target the one with the least position error, the first of equals."""
    position, _ = _errors(rows, protocol.errors.kind, protocol.errors.not_found)
    placed = pd.Series(position, index=rows.index)
    return rows.loc[placed.groupby(rows.target).idxmin()]


def _errors(rows: pd.DataFrame, kind: str, not_found: str) -> tuple[Array, Array]:
    """(N,) position errors in mm and (N,) rotation errors in deg, of one kind."""
    answered = rows.answered.to_numpy(dtype=bool) | (not_found == "own")
    found = []
    for name in ("position_error_mm", "rotation_error_deg"):
        own, idle = (rows[f"{PREFIX[kind]}{which}{name}"] for which in ("", "idle_"))
        found.append(np.where(answered, own.to_numpy(dtype=float), idle.to_numpy(dtype=float)))
    return found[0], found[1]


def _successes(rows: pd.DataFrame, protocol: ProtocolConfig) -> Flags:
    """(N,) which rows count as solved; all where nothing counts as success or failure."""
    rule = protocol.success
    if rule.errors == NO_SUCCESS:
        return np.ones(len(rows), dtype=bool)
    assert rule.position_mm is not None
    assert rule.rotation_deg is not None
    position, rotation = _errors(rows, rule.errors, protocol.errors.not_found)
    reached = within(position, rotation, rule.position_mm, rule.rotation_deg)
    return reached & rows.within_limits.to_numpy(dtype=bool) if rule.limits else reached
