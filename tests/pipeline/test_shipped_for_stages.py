"""A stage in a fresh clone takes the project's weights, unless a training of its own was meant."""

from __future__ import annotations

import shutil
from pathlib import Path

import pandas as pd
import pytest

from pipeline.config import compose
from pipeline.data.files import read_json
from pipeline.errors import MissingArtifactError
from pipeline.learning.card import shipped_weights
from pipeline.learning.weights import load_network
from pipeline.locations import CONF_DIR
from pipeline.perception.weights import shipped_detector
from pipeline.settings import Config
from pipeline.stages import inputs, running
from pipeline.stages.graph import STEPS
from pipeline.stages.shipped import shipped_eyes, shipped_network
from pipeline.stages.solvers import solver_of
from robots import load_robot


@pytest.fixture
def trained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    stages: list[str] = []

    def stage(name: str, config: Config) -> None:
        stages.append(f"{name} {config.robot.name}")

    monkeypatch.setattr(inputs, "home", lambda: tmp_path)
    monkeypatch.setattr(running, "run_stage", stage)
    return stages


def test_plain_values_need_no_training(tmp_path: Path, trained: list[str]) -> None:
    config = compose(["robot=nico", f"results_dir={tmp_path}", "dataset.train=1000"])
    assert running.weights_of("cycleik", config) == shipped_weights("nico")
    assert trained == []


@pytest.mark.parametrize("override", ["train.epochs=2", "model.heads=2", "model=tiny", "seed=1"])
def test_whoever_changes_training_gets_one(
    tmp_path: Path, trained: list[str], override: str
) -> None:
    config = compose(["robot=nico", f"results_dir={tmp_path}", override])
    assert running.weights_of("cycleik", config) == tmp_path / "train" / "nico" / config.model.name
    assert trained == ["train nico"]


@pytest.mark.parametrize(
    ("edited", "line", "put"),
    [
        ("train/compact.yaml", "learning_rate:", "learning_rate: 0.001"),
        ("train/common/run.yaml", "position_beta:", "position_beta: 0.002"),
        ("profile/quick.yaml", "  epochs:", "  epochs: 1000"),
    ],
)
def test_an_edit_of_the_recipe_is_trained(
    tmp_path: Path,
    trained: list[str],
    monkeypatch: pytest.MonkeyPatch,
    edited: str,
    line: str,
    put: str,
) -> None:
    shutil.copytree(CONF_DIR, tmp_path / "conf")
    path = tmp_path / "conf" / edited
    lines = path.read_text(encoding="utf-8").splitlines()
    assert sum(each.startswith(line) for each in lines) >= 1
    path.write_text("\n".join(put if each.startswith(line) else each for each in lines), "utf-8")
    monkeypatch.setattr("pipeline.config.CONF_DIR", tmp_path / "conf")
    config = compose(["robot=nico", f"results_dir={tmp_path}"])
    assert running.weights_of("cycleik", config) == tmp_path / "train" / "nico" / "compact"
    assert trained == ["train nico"]


def test_weights_of_the_run_come_first(tmp_path: Path, trained: list[str]) -> None:
    own = tmp_path / "train" / "nico" / "compact"
    own.mkdir(parents=True)
    (own / "card.json").write_text("{}")
    assert running.weights_of("cycleik", compose(["robot=nico", f"results_dir={tmp_path}"])) == own
    assert trained == []


def test_a_run_knows_the_weights_of_its_neural_solvers_and_no_others(
    tmp_path: Path, trained: list[str]
) -> None:
    config = compose(["robot=nico", f"results_dir={tmp_path}"])
    run = running.with_weights(config, ["lm", "cycleik"])
    assert run.weights == {"cycleik": str(shipped_weights("nico"))}
    assert config.weights == {}
    with pytest.raises(MissingArtifactError, match="train with"):
        solver_of("cycleik", load_robot("nico"), config)
    assert solver_of("cycleik", load_robot("nico"), run).name == "cycleik"


def test_a_shipped_network_lies_where_a_training_leaves_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(inputs, "home", lambda: tmp_path)
    sizes = ["dataset.train=10", "dataset.validation=50", "dataset.test=10"]
    run = ["robot=panda", "train.from=shipped", f"results_dir={tmp_path}", *sizes]
    (folder,) = running.run_stage("train", compose(run))
    shipped = shipped_weights("panda")
    weights = (shipped / "weights.safetensors").read_bytes()
    assert (folder / "weights.safetensors").read_bytes() == weights
    card, theirs = read_json(folder / "card.json"), read_json(shipped / "card.json")
    assert card["config"] == theirs["config"]
    assert card["shipped"].endswith("robots/panda/weights")
    metrics = read_json(folder / "metrics.json")
    assert card["validation"] == metrics, "measured on the poses of this run"
    assert 1 < metrics["position_error_mm"] < 20
    assert metrics["success_10mm_20deg"] > 0.7
    assert pd.read_csv(folder / "curve.csv").empty
    load_network(folder, load_robot("panda"))
    for output in STEPS["train"].outputs:  # DVC refuses a step that leaves one of them out
        assert (tmp_path / output.path.format(robot="panda", model="compact")).exists(), output.path


@pytest.mark.parametrize("override", ["train.epochs=2", "model=tiny", "seed=1"])
def test_no_shipped_network_stands_in_for_another_training(override: str) -> None:
    assert shipped_network(compose(["robot=panda", "train.from=shipped", override])) is None


def test_a_shipped_detector_is_of_these_objects_this_network_and_this_recipe() -> None:
    for plain in ([], ["profile=smoke"], ["detector.held_out_pictures=7"]):
        assert shipped_eyes(compose(["robot=nico", *plain])) == shipped_detector("nico")
    for changed in ("network.width=160", "learning_rate=1.0e-3", "epochs=99", "augment.blur=0.1"):
        assert shipped_eyes(compose(["robot=nico", f"detector.{changed}"])) is None, changed
    assert shipped_eyes(compose(["robot=panda"])) is None
    fewer = "grasp.scenes.nico.objects=[tomato]"
    assert shipped_eyes(compose(["robot=nico", fewer])) is None
