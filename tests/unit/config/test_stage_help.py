"""`<stage> --help` shows the keys that the stage reads, with values and comments, and no others."""

from __future__ import annotations

import pytest
import yaml

from pipeline.__main__ import main
from pipeline.commands.stage_help import comments, stage_help
from pipeline.config import compose, values
from pipeline.stages.graph import STAGES


@pytest.mark.parametrize("name", STAGES)
def test_it_shows_the_groups_of_the_stage_and_no_others(name: str) -> None:
    text = stage_help(name)
    shown = yaml.safe_load(text[text.index("\nseed:") :])
    expected = {"seed", "results_dir", *(group.partition(".")[0] for group in STAGES[name].groups)}
    assert set(shown) == expected
    whole = values()
    for group in STAGES[name].groups:
        if group not in ("solver", "grasp", "grasp.scenes", "agent") and "." not in group:
            assert shown[group] == whole[group]
    if "grasp" in STAGES[name].groups:
        assert set(shown["grasp"]["scenes"]) == {"panda"}, "the scene of the run's robot"


def test_each_value_has_the_comment_of_its_file() -> None:
    lines = stage_help("train").splitlines()
    (rate,) = (line for line in lines if line.startswith("  learning_rate: 0.01"))
    assert "# Adam, at the first step" in rate
    (epochs,) = (line for line in lines if line.startswith("  epochs: 32"))
    assert "# passes over the training set" in epochs
    documented = comments(())
    assert not [key for key in values()["train"] if f"train.{key}" not in documented]


def test_solvers_are_those_of_the_run() -> None:
    text = stage_help("evaluate", ["evaluate.solvers=[placo]"])
    assert set(yaml.safe_load(text[text.index("\nseed:") :])["solver"]) == {"lm", "placo"}
    assert "regularization: 1.0e-05" in text or "regularization: 1e-05" in text
    assert "weight of the task that keeps steps small" in text


def test_overrides_are_heeded(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["train", "--help", "model=flow", "train.learning_rate=0.5"]) == 0
    out = capsys.readouterr().out
    assert "learning_rate: 0.5" in out
    assert "couplings: 4" in out
    assert "train=flow" in out
    assert main(["train", "--help", "train.learning_rat=0.5"]) == 2
    assert "did you mean 'learning_rate'" in capsys.readouterr().err
    assert compose(["model=flow"]).model.couplings == 4
