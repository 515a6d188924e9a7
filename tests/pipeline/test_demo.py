"""`demo` takes the networks that come with the project, and says what it does not understand."""

from __future__ import annotations

import pytest

from pipeline.commands import run_command
from pipeline.config import compose
from pipeline.errors import PipelineError
from pipeline.stages.shipped import shipped_eyes, shipped_network


@pytest.mark.parametrize("robot", ["nicol", "nico", "panda"])
def test_nothing_is_trained_at_its_scale(robot: str) -> None:
    config = compose(["profile=demo", f"robot={robot}"])
    assert config.train.source == config.detector.source == "shipped"
    assert shipped_network(config) is not None
    if robot != "panda":
        assert shipped_eyes(config) is not None


def test_open_is_yes_or_no() -> None:
    with pytest.raises(PipelineError, match="open takes true or false, got maybe"):
        run_command("demo", ["open=maybe"])
