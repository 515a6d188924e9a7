"""A stage in a fresh clone takes the project's weights, unless a training of its own was meant."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.config import compose
from pipeline.learning.weights import shipped_weights
from pipeline.settings import Config
from pipeline.stages import inputs


@pytest.fixture
def trained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    stages: list[str] = []

    def stage(name: str, config: Config) -> None:
        stages.append(f"{name} {config.robot.name}")

    monkeypatch.setattr(inputs, "ROOT", tmp_path)
    monkeypatch.setattr(inputs, "run_stage", stage)
    return stages


def test_plain_values_need_no_training(tmp_path: Path, trained: list[str]) -> None:
    config = compose(["robot=nico", f"results_dir={tmp_path}", "dataset.train=1000"])
    assert inputs.weights_of(config) == shipped_weights("nico")
    assert trained == []


@pytest.mark.parametrize("override", ["train.epochs=2", "model.heads=2", "model=tiny", "seed=1"])
def test_whoever_changes_training_gets_one(
    tmp_path: Path, trained: list[str], override: str
) -> None:
    config = compose(["robot=nico", f"results_dir={tmp_path}", override])
    assert inputs.weights_of(config) == tmp_path / "train" / "nico" / config.model.name
    assert trained == ["train nico"]


def test_weights_of_the_run_come_first(tmp_path: Path, trained: list[str]) -> None:
    own = tmp_path / "train" / "nico" / "compact"
    own.mkdir(parents=True)
    (own / "card.json").write_text("{}")
    assert inputs.weights_of(compose(["robot=nico", f"results_dir={tmp_path}"])) == own
    assert trained == []
