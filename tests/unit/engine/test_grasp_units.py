"""Grasps in units that need no other: what is missing, and rows that are kept as units end."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pipeline.config import compose
from pipeline.data.rows import RowCheckpoint
from pipeline.embodiment.series import AgentSeries
from pipeline.errors import EngineError
from pipeline.grasping import ablation, series
from pipeline.grasping.ablation import Study
from pipeline.grasping.series import Series
from pipeline.stages import grasp_units
from pipeline.stages.grasp_units import run_units

CONFIG = compose(["profile=smoke", "robot=nico", "experiment=grasp_solver", "grasp.trials=5"])
ROW = 3  # objects on a row


def trial(config: Any, robot: Any, solver: Any, number: int, *rest: Any) -> dict[str, Any]:
    if number == 4:
        raise EngineError("the arm fell off")
    return {"trial": number, "class": "Success"}


def row(number: int) -> list[dict[str, Any]]:
    return [{"trial": ROW * number + slot, "class": "Success"} for slot in range(ROW)]


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch) -> Series:
    monkeypatch.setattr(series, "run_trial", trial)
    return Series(CONFIG.grasp, None, "lm", None, 0)  # type: ignore[arg-type]


def test_units_are_what_is_not_kept(plain: Series, tmp_path: Path) -> None:
    kept = RowCheckpoint(tmp_path / "rows.jsonl", series.KEY)
    for number in (0, 3):
        kept.put({"trial": number})
    assert plain.pending(kept) == [1, 2, 4]

    objects = SimpleNamespace(series=plain, per_row=ROW, row=row)
    agent = AgentSeries(objects)  # type: ignore[arg-type]
    assert agent.pending(kept) == [0, 1]
    assert [one["trial"] for one in agent.unit(1)] == [3, 4]  # five trials are wanted
    for number in (1, 2):
        kept.put({"trial": number})
    assert agent.pending(kept) == [1]

    study = Study(plain, lambda name: name)  # type: ignore[arg-type,return-value]
    kept = RowCheckpoint(tmp_path / "study.jsonl", ablation.KEY)
    (first,) = study.unit((1, 2))
    kept.put(first)
    units = study.pending(kept)
    assert len(units) == study.trials - 1
    assert (1, 2) not in units


def test_rows_are_kept_unit_by_unit_and_a_failure_leaves_them(
    plain: Series, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loads = []

    def load(config: Any) -> Series:
        loads.append(config)
        return plain

    def one_by_one(engine: Any, function: Any, tasks: Any, finished: Any, title: str) -> None:
        for number, task in enumerate(tasks):
            finished(number, function(task))

    monkeypatch.setattr(grasp_units, "load_runner", load)
    monkeypatch.setattr(grasp_units, "run_tasks", one_by_one)
    kept = RowCheckpoint(tmp_path / "rows.jsonl", series.KEY)
    run_units(CONFIG, plain, kept)
    assert not kept.path.exists()  # a single worker here: the series itself runs
    apart = replace(CONFIG, engine=replace(CONFIG.engine, workers=2))
    with pytest.raises(EngineError, match="fell off"):
        run_units(apart, plain, kept)
    assert plain.pending(RowCheckpoint(kept.path, series.KEY)) == [4]
    assert len(loads) == 1
