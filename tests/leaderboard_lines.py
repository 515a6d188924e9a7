"""A line of the leaderboard with plain numbers: nothing in it was measured."""

from __future__ import annotations

from typing import Any

from pipeline.leaderboard.schema import FIELDS

LINE: dict[str, Any] = {
    **dict.fromkeys(FIELDS, 0),
    "suite": "warm",
    "suite_version": 1,
    "suite_checksum": "ab" * 32,
    "robot": "nico",
    "robot_source": "",
    "profile": "quick",
    "solver": "lm",
    "versions": "numpy 2",
    "network": "",
    "processor": "a processor",
    "threads": 1,
    "batch_size": 1,
    "timed_by": "here",
    "date": "2026-11-28",
    "commit": "0123abc",
    "answers_sha256": "cd" * 32,
    "criterion": "solved",
    "trials": 100,
    "good": 90,
    "poses": 100,
    "good_poses": 90,
    "time_geometric_us": 20.0,
    "within_10us": 40,
    "within_100us": 90,
}
