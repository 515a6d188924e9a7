"""Trackers are told the curve of a training, each row at its step."""

from __future__ import annotations

import sqlite3
import sys
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import pytest

from pipeline.config import compose
from pipeline.errors import MissingPackageError
from pipeline.learning.tracker import TrackerConfig, tracked

ROWS = [(100, {"step": 100, "loss": 0.5}), (200, {"step": 200, "loss": 0.25})]


def report_to(kind: str, folder: Path) -> None:
    with tracked(TrackerConfig(kind), folder, "train panda tiny", {"train": {"a": 1}}) as report:
        for step, row in ROWS:
            report(step, row)


def test_none_writes_nothing(tmp_path: Path) -> None:
    report_to("none", tmp_path / "tracker")
    assert not (tmp_path / "tracker").exists()


def test_tensorboard_gets_scalars(tmp_path: Path) -> None:
    pytest.importorskip("tensorboard")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    report_to("tensorboard", tmp_path)
    report_to("tensorboard", tmp_path)  # as a training that goes on: its rows stand there once
    events = EventAccumulator(str(tmp_path / "train" / "panda" / "tiny"))
    events.Reload()
    assert events.Tags()["scalars"] == ["loss"]
    assert [(event.step, event.value) for event in events.Scalars("loss")] == [
        (100, 0.5),
        (200, 0.25),
    ]


def test_mlflow_gets_metrics_and_settings_in_one_file(tmp_path: Path) -> None:
    pytest.importorskip("mlflow")
    pytest.importorskip("sqlalchemy")
    report_to("mlflow", tmp_path)
    with sqlite3.connect(tmp_path / "mlflow.db") as base:
        metrics = base.execute("select key, step, value from metrics order by step").fetchall()
        settings = base.execute("select key, value from params").fetchall()
        states = base.execute("select status from runs").fetchall()
    assert metrics == [("loss", 100, 0.5), ("loss", 200, 0.25)]
    assert settings == [("train.a", "1")]
    assert states == [("FINISHED",)]


def test_mlflow_marks_a_run_that_did_not_reach_its_end(tmp_path: Path) -> None:
    pytest.importorskip("mlflow")
    pytest.importorskip("sqlalchemy")
    with (
        pytest.raises(KeyboardInterrupt),
        tracked(TrackerConfig("mlflow"), tmp_path, "train panda tiny", {}),
    ):
        raise KeyboardInterrupt
    with sqlite3.connect(tmp_path / "mlflow.db") as base:
        assert base.execute("select status from runs").fetchall() == [("KILLED",)]


@pytest.mark.slow
def test_workers_make_the_database_of_mlflow_together(tmp_path: Path) -> None:
    pytest.importorskip("mlflow")
    pytest.importorskip("sqlalchemy")
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as workers:
        list(workers.map(report_to, ["mlflow"] * 2, [tmp_path] * 2))
    with sqlite3.connect(tmp_path / "mlflow.db") as base:
        assert base.execute("select status from runs").fetchall() == [("FINISHED",)] * 2


@pytest.mark.parametrize(
    ("kind", "package"), [("tensorboard", "torch.utils.tensorboard"), ("mlflow", "mlflow")]
)
def test_a_missing_package_is_named(
    kind: str, package: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingPackageError, match=rf"tracker={kind} needs {kind}: pip install"):
        report_to(kind, tmp_path)


def test_choices_are_files_of_conf() -> None:
    for kind in ("none", "tensorboard", "mlflow"):
        assert compose([f"tracker={kind}"]).tracker.kind == kind
    with pytest.raises(ValueError, match=r"tracker\.kind must be one of none, tensorboard, mlflow"):
        TrackerConfig("wandb")
