"""The committed study of learned methods in the report."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from pipeline.data.files import write_text
from pipeline.presentation.origin import Origin
from pipeline.presentation.table import write_origin
from pipeline.reporting.results import Results
from pipeline.reporting.topics.learned import NAME, committed, learned_methods

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
    table = committed(Results(tmp_path / "quick"))
    assert table.shown() == made.shown()  # titles of robots and solvers are read as what they are
    assert table.origin == origin
    assert table.shown()[0][:5] == ["Panda", "IKFlow", "published", "–", "7.72"]
    assert table.shown()[1][-3:] == ["5,000", "180", "cpu"]


def test_without_a_study_there_is_no_table(tmp_path: Path) -> None:
    assert committed(Results(tmp_path / "quick")).rows == []
