"""The stage `detector` at its smallest: from rendering to weights that load again."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.config import compose
from pipeline.data.files import read_json, sha256
from pipeline.data.tables import read_table
from pipeline.perception.training import DetectorTrainer
from pipeline.perception.weights import WEIGHTS, read_detector_card
from pipeline.settings import Config
from pipeline.stages import detector
from pipeline.stages.eyes import detector_of
from robots import load_robot

SMALL = {
    "pictures": 16,
    "held_out_pictures": 4,
    "chunk": 8,
    "epochs": 2,
    "batch_size": 4,
    "figure_pictures": 2,
    "network.width": 128,
    "network.height": 96,
}


def small(folder: Path) -> Config:
    keys = [f"detector.{key}={value}" for key, value in SMALL.items()]
    return compose(["robot=nico", "profile=smoke", f"results_dir={folder}", *keys])


def test_a_killed_run_goes_on_and_ends_at_the_same_weights(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, broken = (small(tmp_path / name) for name in ("whole", "broken"))
    detector.run(whole)
    step, steps = DetectorTrainer._step, []

    def killed(self: DetectorTrainer, *arguments: object) -> float:
        steps.append(arguments)
        if len(steps) == 6:
            raise KeyboardInterrupt
        return step(self, *arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(DetectorTrainer, "_step", killed)
    with pytest.raises(KeyboardInterrupt):
        detector.run(broken)
    before = len(steps)
    assert before == 6
    detector.run(broken)
    assert len(steps) - before == 4  # the second of two epochs, from its beginning
    folders = [tmp_path / name / "detector/nico" for name in ("whole", "broken")]
    assert sha256(folders[0] / WEIGHTS) == sha256(folders[1] / WEIGHTS)
    assert not list((tmp_path / "broken/checkpoint").glob("detector-*"))
    _check_artifacts(folders[0])
    loaded = detector_of(load_robot("nico"), whole)
    assert loaded.names == ("grapes", "tomato", "lemon_half")


def _check_artifacts(folder: Path) -> None:
    rows = read_table(folder / "errors.parquet", ["picture", "name", "kind", "score", "error_m"])
    assert set(rows.kind) <= {"found", "missed", "false"}
    assert rows.picture.nunique() == 4
    metrics = read_json(folder / "metrics.json")
    assert metrics["objects"] == int((rows.kind != "false").sum())
    card = read_detector_card(folder, "nico")
    assert card["held_out"]["map50"] == metrics["map50"]
    assert metrics["train_core_s"] > 0
    for name in ("detections.png", "errors.png"):
        assert (folder / name).stat().st_size > 1000


def test_without_a_run_of_their_own_robots_take_the_projects_detector(tmp_path: Path) -> None:
    config = compose(["robot=nicol", f"results_dir={tmp_path}", "profile=smoke"])
    assert "banana" in detector_of(load_robot("nicol"), config).names
