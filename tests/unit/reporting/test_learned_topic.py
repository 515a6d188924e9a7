"""Committed studies in the report: learned methods, TRAC-IK and BioIK beside their authors'."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.table_three.__main__ import pose_count
from pipeline.data.files import write_text
from pipeline.errors import PipelineError
from pipeline.locations import results
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import Table, write_origin
from pipeline.reporting.committed import committed
from pipeline.reporting.results import Results
from pipeline.reporting.topics.calibration import (
    BUDGETS,
    CALIBRATION,
    bio_ik_budgets,
    trac_ik_calibration,
)
from pipeline.reporting.topics.learned import NAME, learned_methods

PUBLISHED = {"robot": "panda", "solver": "ikflow", "source": "published", "position_mm": 7.72}
OURS = {"robot": "panda", "solver": "gan", "source": "equal time", "of": "10 draws", "poses": 5000}
EMPTY = ("rotation_deg", "paper_position_mm", "paper_rotation_deg", "call_ms", "parameters")


def rows() -> pd.DataFrame:
    frame = pd.DataFrame([PUBLISHED, OURS])
    return frame.assign(**dict.fromkeys(EMPTY, float("nan")), seconds=180.4, device="cpu")


def test_a_study_beside_the_profiles_is_shown_with_its_own_origin(tmp_path: Path) -> None:
    made = learned_methods(rows())
    origin = Origin("python -m benchmarks.table_three", commit="abc", date="2026-01-02")
    write_text(tmp_path / "studies" / f"{NAME}.csv", made.to_csv())
    write_origin(tmp_path / "studies", NAME, origin)
    table = committed(Results(tmp_path / "quick"), NAME, learned_methods)
    assert table.shown() == made.shown()  # titles of robots and solvers are read as what they are
    assert table.origin == origin
    assert table.shown()[0][:5] == ["Panda", "IKFlow", "published", "–", "7.72"]
    assert table.shown()[1][-3:] == ["5,000", "180", "cpu"]


def test_without_a_study_there_is_no_table(tmp_path: Path) -> None:
    assert committed(Results(tmp_path / "quick"), NAME, learned_methods).rows == []


@pytest.mark.parametrize(
    ("name", "make", "solved", "published"),
    [
        (CALIBRATION, trac_ik_calibration, "99.87", "99.70"),
        (BUDGETS, bio_ik_budgets, "97.10", "96.76"),
    ],
)
def test_calibrations_of_the_checkout_are_shown_beside_the_published_rates(
    name: str, make: Callable[[pd.DataFrame], Table], solved: str, published: str
) -> None:
    table = committed(Results(results() / "quick"), name, make)
    assert table.origin is not None and table.origin.command.startswith(
        f"python -m benchmarks.{name}"
    )
    rows = [dict(zip((c.name for c in table.columns), row, strict=True)) for row in table.shown()]
    assert not any("–" in row.values() for row in rows)  # every column has its value
    assert any(
        (
            row["solved_percent" if name == CALIBRATION else "success_percent"],
            row["published_percent"],
        )
        == (solved, published)
        for row in rows
    )


def test_no_more_poses_are_said_than_there_are() -> None:
    assert [pose_count(wanted, 500) for wanted in (0, 50, 199, 500)] == [100, 100, 100, 500]
    with pytest.raises(PipelineError, match="600 poses are wanted, and the test set has 500"):
        pose_count(600, 500)
