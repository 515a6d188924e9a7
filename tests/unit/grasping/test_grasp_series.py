"""A series of trials: films of an earlier run do not stay beside the new ones."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from pipeline.config import compose
from pipeline.data.rows import RowCheckpoint
from pipeline.grasping import series as module
from pipeline.grasping.series import KEY, Series

CONFIG = replace(compose(["profile=smoke"]).grasp, trials=3, video="first")


class Film:
    def __init__(self, config: Any) -> None:
        pass

    def write(self, path: Path) -> None:
        path.write_text("film")

    def stills(self, columns: int) -> Film:
        return self

    save = write


@pytest.fixture
def series(monkeypatch: pytest.MonkeyPatch) -> Series:
    def trial(config: Any, robot: Any, solver: Any, number: int, *rest: Any) -> dict[str, Any]:
        return {"trial": number, "class": "Success"}

    monkeypatch.setattr(module, "run_trial", trial)
    monkeypatch.setattr(module, "Recorder", Film)
    return Series(CONFIG, robot=None, solver=None, repair=None, seed=0)  # type: ignore[arg-type]


def test_films_of_an_earlier_run_are_removed(series: Series, tmp_path: Path) -> None:
    for name in (
        "trial000_slipped.mp4",
        "trial003_slipped.gif",
        "trial007_success.png",
        "mine.png",
    ):
        (tmp_path / name).write_text("old")
    series.film(pd.DataFrame({"trial": [0], "class": ["Success"]}), tmp_path)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == ["mine.png", "trial000_success.mp4", "trial000_success.png"]


def test_kept_trials_are_not_run_again(series: Series, tmp_path: Path) -> None:
    kept = RowCheckpoint(tmp_path / "rows.jsonl", KEY)
    kept.put({"trial": 1, "class": "Slipped"})
    rows = series.run(RowCheckpoint(kept.path, KEY), lambda row: None)
    assert list(rows["class"]) == ["Success", "Slipped", "Success"]
