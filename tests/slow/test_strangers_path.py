"""The commands of docs/tutorials/stranger.md, typed in a clone: a robot of yours on the page."""

from __future__ import annotations

import shutil
import sysconfig
from pathlib import Path

import pytest

from benchmarks.stranger import ROOT, STEPS, UR5, commands, walked

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not (Path(sysconfig.get_path("purelib")) / UR5).exists(), reason="needs example-robot-data"
    ),
    pytest.mark.skipif(
        shutil.which("git") is None or not (ROOT / ".git").exists(), reason="needs git"
    ),
]


def test_the_page_has_each_step_once() -> None:
    lines = [" ".join(words) for words in commands("packages")]
    assert [begin for line in lines for begin in STEPS if line.startswith(begin)] == [*STEPS]


def test_a_robot_of_ones_own_is_trained_judged_and_on_the_page(tmp_path: Path) -> None:
    table = walked(tmp_path, "smoke", environment=False)
    assert len(table) == len(STEPS)  # without the environment, with the sum
    assert (table.wall_s > 0).all()
