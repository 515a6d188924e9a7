"""Who is ahead on a board, and within what time: by hand, and without claims by chance."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.leaderboard.boards import put, read_boards
from pipeline.leaderboard.leads import ANY_TIME, leads
from tests.leaderboard_lines import LINE


def board(folder: Path, *changes: dict[str, Any]) -> pd.DataFrame:
    for change in changes:
        put(folder, "desk", {**LINE, "good": 100, "good_poses": 100, **change})
    return read_boards(folder)


def test_rates_that_are_level_are_told_apart_by_a_time(tmp_path: Path) -> None:
    lines = board(
        tmp_path,
        {"solver": "lm", "within_10us": 90, "within_100us": 100},
        {"solver": "placo", "within_10us": 20, "within_100us": 95},
        {"solver": "slow", "within_10us": 0, "within_100us": 5},
    )
    (lead,) = leads(lines, 0.95)
    assert (lead["best"], lead["second"], lead["within_us"]) == ("lm", "placo", "10")
    assert lead["apart"] == "yes"
    assert lead["best_share"] == pytest.approx(0.9)
    # Wilson at 1 - 0.05 / 3, z = 2.394: 90 of 100 from 0.804, 20 of 100 to 0.312.
    assert lead["best_low"] == pytest.approx(0.804, abs=2e-3)
    assert lead["second_high"] == pytest.approx(0.312, abs=2e-3)


def test_where_nothing_tells_them_apart_the_rate_without_a_limit_is_said(tmp_path: Path) -> None:
    both = {"within_10us": 50, "within_100us": 99}
    (lead,) = leads(board(tmp_path, {"solver": "lm", **both}, {"solver": "placo", **both}), 0.95)
    assert (lead["apart"], lead["within_us"], lead["best_share"]) == ("no", ANY_TIME, 1.0)


def test_waypoints_count_for_no_more_than_their_trajectories(tmp_path: Path) -> None:
    """95 and 85 % of 10,000 waypoints, but of 10 trajectories: 9.5 and 8.5 of ten."""
    of = {"poses": 10000, "good_poses": 10000, "trials": 10, "good": 10}
    lines = board(
        tmp_path,
        {"solver": "lm", **of, "within_10us": 9500, "within_100us": 10000},
        {"solver": "placo", **of, "within_10us": 8500, "within_100us": 10000},
    )
    assert leads(lines, 0.95)[0]["apart"] == "no"
    assert leads(lines.iloc[:1], 0.95) == [] == leads(lines.iloc[:0], 0.95)


def test_a_solver_of_few_trials_may_be_as_good_as_the_first(tmp_path: Path) -> None:
    """Wilson: 190 of 200 from 0.910, 160 of 200 to 0.850, but 16 of 20 to 0.919."""
    untimed = dict.fromkeys([name for name in LINE if name.endswith("us")], "")
    lines = board(
        tmp_path,
        {"solver": "lm", **untimed, "trials": 200, "good": 190},
        {"solver": "placo", **untimed, "trials": 200, "good": 160},
        {"solver": "slow", **untimed, "trials": 20, "good": 16},
    )
    (lead,) = leads(lines, 0.95)
    assert (lead["best"], lead["second"], lead["apart"]) == ("lm", "slow", "no")
    assert leads(lines[lines.solver != "slow"], 0.95)[0]["apart"] == "yes"
