"""What the zoo's table, verdict and figure say of rows."""

from __future__ import annotations

import pandas as pd
import pytest

from pipeline.zoo.arms import ZooConfig
from pipeline.zoo.reporting import COLUMNS, figure_of, table_of, verdict

SIZES = ZooConfig(minutes=1.0, train=1, validation=1, poses=5000, rounds=1, seed=0)


@pytest.fixture
def rows() -> pd.DataFrame:
    frame = pd.DataFrame(
        {
            "arm": ["long", "short", "middle"],
            "joints": [10, 5, 7],
            "range_rad": [2.0, 6.0, 4.0],
            "home_first_start": [0.9, 0.95, 0.7],
            "gain_iterations": [0.9, 4.0, 2.0],
            "gain_time": [0.4, 1.6, 1.2],
        }
    )
    names = [column.name for column in COLUMNS]
    return frame.reindex(columns=names).fillna(dict.fromkeys(names, 1.0))


def test_the_verdict_counts_and_names_arms(rows: pd.DataFrame) -> None:
    first, second = verdict(rows.assign(home_first_start=[0.9, 0.95, 0.7]))
    assert "saves iterations on 2 of 3 arms (median gain 2.00)" in first
    assert "on 2: short, middle (median gain 1.20)" in first
    assert "-1.00 with joints; +1.00 with mean range of the turning joints;" in second
    assert "+0.50 with share" in second  # ranks 2 3 1 against 1 3 2: 1 - 6 (1 + 0 + 1) / 24


def test_two_arms_are_no_ground_for_a_verdict(rows: pd.DataFrame) -> None:
    assert verdict(rows[:2]) == []


def test_the_table_begins_with_the_fewest_joints(rows: pd.DataFrame) -> None:
    table = table_of(rows, SIZES, ["Left out: none."])
    assert [line[0] for line in table.rows] == ["short", "middle", "long"]
    assert table.notes[-1] == "Left out: none."
    assert "1 minutes of one core" in table.caption


def test_the_figure_marks_every_arm_in_every_panel(rows: pd.DataFrame) -> None:
    for axis in figure_of(rows).axes:
        assert [text.get_text() for text in axis.texts] == ["long", "short", "middle"]
