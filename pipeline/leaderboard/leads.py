"""Where one solver is certainly ahead of all others on a board, and within what time of a call."""

from __future__ import annotations

from typing import Any

import pandas as pd

from pipeline.evaluation.statistics import wilson_interval
from pipeline.leaderboard.schema import WITHIN, limits_of
from pipeline.leaderboard.standings import KEYS
from pipeline.reporting.suite_leaders import ahead

ANY_TIME = "any"


def leads(lines: pd.DataFrame, confidence: float) -> list[dict[str, Any]]:
    """Return for each board the limit of time within which the first is furthest ahead for certain.

    A solver's rate is its share of poses that are solved by calls of at most so long; unlimited, it
    is that of the board. Limits that are tried on a board share the probability of an error
    (Bonferroni), so that the choice among them claims nothing by chance. Waypoints of a trajectory
    hang together, so that their shares count for as many trials as there are trajectories.

    Args:
        lines: Of `pipeline.leaderboard.boards.read_boards`.
        confidence: Of all statements on a board together.

    Returns:
        A record a board; ``apart`` is "no" where no limit tells the first two apart, which are then
        those of any time.
    """
    if lines.empty:
        return []
    found = []
    for key, board in lines.groupby(KEYS, sort=False):
        if len(board) > 1:
            named = dict(zip(KEYS, key, strict=True))
            found.append({**named, **_widest(board, confidence)})
    return found


def _widest(board: pd.DataFrame, confidence: float) -> dict[str, Any]:
    limits = [name for name in limits_of(board) if board[name].notna().all()]
    each = 1.0 - (1.0 - confidence) / (len(limits) + 1)
    rates = {ANY_TIME: board.good / board.trials}
    rates |= {_limit(name): board[name] / board.poses for name in limits}
    tried = [_first_two(board, rate, each) | {"within_us": time} for time, rate in rates.items()]
    widest = max(tried, key=lambda two: float(two["best_low"] - two["second_high"]))
    return widest if widest["apart"] == "yes" else tried[0]


def _first_two(board: pd.DataFrame, rates: pd.Series, confidence: float) -> dict[str, Any]:
    return ahead(
        [
            (str(solver), wilson_interval(round(rate * trials), int(trials), confidence))
            for rate, trials, solver in zip(rates, board.trials, board.solver, strict=True)
        ]
    )


def _limit(name: str) -> str:
    match = WITHIN.fullmatch(name)
    assert match is not None
    return match[1]
