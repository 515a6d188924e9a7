"""What is kept knows the code that made it; what later stages read does not."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from pipeline.config import compose
from pipeline.settings import Config
from pipeline.stages import dataset, solvers, train
from pipeline.stages.running import run_stage
from robots.sampling import sample_configurations

FEW = tuple(
    f"dataset.{split}={count}" for split, count in (("train", 40), ("validation", 20), ("test", 20))
)


def config(folder: Path) -> Config:
    tiny = ("profile=smoke", "train.epochs=1", "train.batch_size=20", "train.device=cpu")
    return compose(["robot=panda", f"results_dir={folder}", *tiny, *FEW])


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Sizes of the pose sets that were drawn, rather than kept."""
    counts: list[int] = []

    def sample(robot: object, count: int, **more: object) -> object:
        counts.append(count)
        return sample_configurations(robot, count, **more)  # type: ignore[arg-type]

    monkeypatch.setattr(dataset, "sample_configurations", sample)
    return counts


def other_code(monkeypatch: pytest.MonkeyPatch, module: object) -> None:
    monkeypatch.setattr(module, "source_tree", lambda: SimpleNamespace(digest=lambda *_: "other"))


def test_pose_sets_of_other_code_are_drawn_again_and_are_the_same_artifact(
    tmp_path: Path, drawn: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "dataset" / "panda"
    run_stage("dataset", config(tmp_path))
    assert drawn == [40, 20, 20]
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    run_stage("dataset", config(tmp_path))
    assert drawn == [40, 20, 20]
    other_code(monkeypatch, dataset)
    run_stage("dataset", config(tmp_path))
    assert drawn == [40, 20, 20] * 2
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_card_of_weights_does_not_name_the_code_but_a_checkpoint_does(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    digests: list[str] = []
    make = train.TrainingRun

    def training_run(seed: int, digest: str, *more: object) -> object:
        digests.append(digest)
        return make(seed, digest, *more)  # type: ignore[arg-type]

    monkeypatch.setattr(train, "TrainingRun", training_run)
    card = tmp_path / "train" / "panda" / "tiny" / "card.json"
    run_stage("train", config(tmp_path))
    before = card.read_text(encoding="utf-8")
    other_code(monkeypatch, train)
    run_stage("train", config(tmp_path))
    assert card.read_text(encoding="utf-8") == before
    first, second = digests
    assert first != second


def test_rows_of_other_solvers_are_of_other_code() -> None:
    run = compose()

    def code(*names: str, config: Config = run) -> str:
        return solvers.code_of("pipeline.stages.evaluate", {"solver": names}, config)

    assert code("lm") == code("lm")
    assert code("lm") != code("trac_ik")
    assert code("lm") != code("lm", "cycleik")
    flow = compose(["solver.cycleik_refined.proposer=flow"])
    assert code("cycleik_refined", config=flow) != code("cycleik_refined")
