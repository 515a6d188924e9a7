"""The arms of the zoo: read, brought in once, and refused in a sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import ConfigError
from pipeline.zoo import arms
from pipeline.zoo.arms import Arm, MissingArmError, read_zoo, robot_of_arm
from tests.small_arms import arm, save


@pytest.fixture
def libraries(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(arms.sysconfig, "get_path", lambda name: str(tmp_path / "libraries"))
    (tmp_path / "libraries").mkdir()
    return tmp_path / "libraries"


def test_sizes_are_those_of_the_file_unless_typed() -> None:
    sizes, known = read_zoo({"minutes": "0.5", "poses": "7"})
    assert (sizes.minutes, sizes.poses, sizes.seed) == (0.5, 7, 0)
    assert len(known) >= 20
    assert known["panda"] == Arm("panda")
    assert known["ur5"].tip == "tool0"


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"minutes": "long"}, "minutes must be a number, got 'long'"),
        ({"poses": "2.5"}, "poses must be a number, got '2.5'"),
        ({"rounds": "0"}, "rounds"),
    ],
)
def test_sizes_that_cannot_be_are_refused(given: dict[str, str], sentence: str) -> None:
    with pytest.raises(ConfigError, match=sentence):
        read_zoo(given)


def test_an_arm_of_a_package_becomes_a_robot_once(libraries: Path, tmp_path: Path) -> None:
    urdf = save(libraries, arm(4))
    wanted = Arm("guest", urdf.name, "b", "l4")
    robot = robot_of_arm(wanted, tmp_path / "robots")
    assert (robot.name, robot.dof, robot.tip) == ("guest", 4, "l4")
    urdf.write_text("<robot", encoding="utf-8")  # it is read from the zoo's folder from now on
    assert robot_of_arm(wanted, tmp_path / "robots").joint_names == robot.joint_names


def test_a_package_that_is_not_there_is_named(libraries: Path, tmp_path: Path) -> None:
    with pytest.raises(MissingArmError, match=r"no installed package has nowhere/robot\.urdf"):
        robot_of_arm(Arm("guest", "nowhere/robot.urdf", "b", "l4"), tmp_path)


def test_an_arm_without_a_file_is_one_of_the_project(tmp_path: Path) -> None:
    assert robot_of_arm(Arm("nico"), tmp_path).dof == 6
    assert not list(tmp_path.iterdir())
