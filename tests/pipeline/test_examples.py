"""The examples: what each prints is what it is about. Those that train or grasp: tests/slow."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests import examples
from tests.examples import EXAMPLES, SLOW, scripts

output = examples.output
LONGEST = 40  # lines, exclusive
FOLDER = EXAMPLES.parent


def test_there_are_ten_short_ones_and_each_is_tested() -> None:
    names = [path.name for path in scripts()]
    assert [name[:3] for name in names] == [f"{k:02d}_" for k in range(1, 11)]
    for path in scripts():
        assert len(path.read_text(encoding="utf-8").splitlines()) < LONGEST, path.name
    here = Path(__file__).read_text(encoding="utf-8")
    slow = (FOLDER / "tests/slow/test_slow_examples.py").read_text(encoding="utf-8")
    for name in names:
        assert f'"{name[:2]}"' in (slow if name[:2] in SLOW else here), name


@pytest.mark.parametrize("output", ["01"], indirect=True)
def test_a_urdf_is_solved(output: str) -> None:
    assert "7 joints from panda_link0 to panda_hand_tcp" in output
    assert float(re.findall(r"([\d.]+) mm off", output)[0]) < 0.1  # the tolerance of lm
    assert "1000 are found" in output


@pytest.mark.parametrize("output", ["02"], indirect=True)
def test_one_pose_has_many_solutions(output: str) -> None:
    differ, free = map(int, re.findall(r"(\d+) solutions differ .* (\d+) of them", output)[0])
    assert 20 < free <= differ <= 200
    assert float(re.findall(r"target: ([\d.]+) mm", output)[0]) < 0.1


@pytest.mark.parametrize("output", ["03"], indirect=True)
def test_a_path_is_followed_without_a_jump(output: str) -> None:
    assert "4000 targets, 0 missed" in output
    # The circle's tip moves 0.126 m/s, 0.13 mm a target: no joint needs a hundredth of a radian.
    assert float(re.findall(r"step of a joint ([\d.]+)", output)[0]) < 2e-3


@pytest.mark.parametrize("output", ["04"], indirect=True)
def test_an_own_solver_is_judged_beside_lm(output: str) -> None:
    assert re.search(r"^Transpose: \d+% within", output, re.MULTILINE)
    assert "lm: 100% within" in output


@pytest.mark.parametrize("output", ["05"], indirect=True)
def test_a_motion_is_planned_and_drawn(output: str, tmp_path: Path) -> None:
    assert "50 of 50 waypoints" in output
    assert "0 branch flips" in output
    assert (tmp_path / "motion.png").stat().st_size > 5000


@pytest.mark.parametrize("output", ["08"], indirect=True)
def test_a_map_shows_where_the_robot_reaches(output: str) -> None:
    rows = [line.split() for line in output.splitlines() if set(line) <= set("oxB. ")]
    assert [len(row) for row in rows] == [31] * 31
    for corner in (rows[0][0], rows[0][-1], rows[-1][0], rows[-1][-1]):
        assert corner == "."  # 1.27 m from the base; the arm is 0.855 m long
    area = sum(row.count("o") for row in rows) * 0.06**2
    assert float(re.findall(r"([\d.]+) m2", output)[0]) == pytest.approx(area, abs=0.01)
