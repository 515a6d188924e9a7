"""The examples that train, make pose sets or simulate."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests import examples

pytestmark = pytest.mark.slow
output = examples.output


@pytest.mark.parametrize("output", ["06"], indirect=True)
def test_a_network_is_trained_and_exported(output: str, tmp_path: Path) -> None:
    assert float(output.split("the same to ")[1].split()[0]) < 1e-5
    assert (tmp_path / "nico_ik.pt").exists()
    assert "int nico_ik_solve(" in (tmp_path / "nico_ik.h").read_text(encoding="utf-8")


@pytest.mark.parametrize("output", ["07"], indirect=True)
def test_the_overridden_key_is_what_differs(output: str) -> None:
    assert "configuration: 1 of" in output
    assert "solver.patience  8  2" in output


@pytest.mark.parametrize("output", ["09"], indirect=True)
def test_an_own_object_lands_in_a_bin(output: str) -> None:
    assert output.count("bottle") == 2
    assert "Success" in output


@pytest.mark.parametrize("output", ["10"], indirect=True)
def test_the_robot_answers(output: str) -> None:
    assert "grasp banana: done" in output
    assert "point orange: done" in output
    assert "I do not see an elephant." in output
