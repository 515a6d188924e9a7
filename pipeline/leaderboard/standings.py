"""Who is where: ranks within a board, and how a solver does over all boards of a machine."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from pipeline.evaluation.statistics import wilson_interval

KEYS = ["machine", "robot", "suite"]  # of a board


def ranked(lines: pd.DataFrame, confidence: float) -> pd.DataFrame:
    """Add shares, their Wilson intervals and ranks to lines of boards.

    A rank is one more than the solvers of the same board that are certainly better: whose interval
    lies above. Equal ranks stand in the order of share, then of time.

    Args:
        lines: Of `pipeline.leaderboard.boards.read_boards`.
        confidence: Of the intervals.

    Returns:
        The lines with ``share``, ``low``, ``high``, ``rank``, ``front``: whether no other is both
        faster and more precise; board by board, the best first.
    """
    if lines.empty:
        return lines
    intervals = [
        wilson_interval(int(good), int(trials), confidence)
        for good, trials in zip(lines.good, lines.trials, strict=True)
    ]
    lines = lines.assign(
        share=[each.estimate for each in intervals],
        low=[each.low for each in intervals],
        high=[each.high for each in intervals],
        self_collision_share=lines.self_colliding / lines.good_poses.replace(0, np.nan),
    )
    boards = [_placed(board) for _, board in lines.groupby(KEYS, sort=False)]
    return pd.concat(boards, ignore_index=True)


def _placed(board: pd.DataFrame) -> pd.DataFrame:
    above = [int((board.low > high).sum()) for high in board.high]
    placed = board.assign(rank=[1 + n for n in above], front=on_front(board))
    return placed.sort_values(
        ["rank", "share", "time_geometric_us"], ascending=[True, False, True], kind="stable"
    )


def on_front(board: pd.DataFrame) -> list[bool]:
    """Whether each line is on the Pareto front of time and median position error.

    One without times is not; of equal ones all are.
    """
    times, errors = board.time_geometric_us.to_numpy(), board.position_median_mm.to_numpy()
    return [
        not np.isnan(time)
        and not bool(
            ((times <= time) & (errors <= error) & ((times < time) | (errors < error))).any()
        )
        for time, error in zip(times, errors, strict=True)
    ]


def overall(lines: pd.DataFrame) -> list[dict[str, Any]]:
    """Sum up a solver over all boards of a machine, the lowest mean rank first.

    Those that are on fewer boards stand behind: means over other boards do not compare.

    Args:
        lines: Of `ranked`.
    """
    found = []
    for (machine, solver), mine in lines.groupby(["machine", "solver"], sort=False):
        times = mine.time_geometric_us.dropna()
        found.append(
            {
                "machine": machine,
                "solver": solver,
                "boards": len(mine),
                "first": int((mine["rank"] == 1).sum()),
                "mean_rank": float(mine["rank"].mean()),
                "mean_share": float(mine.share.mean()),
                "least_share": float(mine.share.min()),
                "time_us": float(np.exp(np.log(times).mean())) if len(times) else None,
            }
        )
    return sorted(
        found,
        key=lambda each: (
            each["machine"],
            -each["boards"],
            each["mean_rank"],
            -each["mean_share"],
        ),
    )
