"""The arms of the zoo: read, brought in once, and refused in a sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import ConfigError
from pipeline.locations import CONF_DIR
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


def test_a_robot_that_was_brought_in_with_another_chain_is_not_taken(
    libraries: Path, tmp_path: Path
) -> None:
    urdf = save(libraries, arm(4))
    robot_of_arm(Arm("guest", urdf.name, "b", "l4"), tmp_path / "robots")
    with pytest.raises(ConfigError, match=r"goes from b to l4, and zoo.yaml says b to l3"):
        robot_of_arm(Arm("guest", urdf.name, "b", "l3"), tmp_path / "robots")


@pytest.mark.parametrize(
    ("entry", "fits"),
    [
        ("nico:", True),
        ("nico: {}", True),
        ("guest: {urdf: a.urdf, base: b, tip: t}", True),
        ("guest: {urdf: a.urdf, base: b}", False),
        ("guest: {urdf: a.urdf, base: b, tip: t, end: e}", False),
        ("guest: a.urdf", False),
        ("Guest: {urdf: a.urdf, base: b, tip: t}", False),
    ],
)
def test_an_entry_is_a_robot_or_a_whole_chain(
    entry: str, fits: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (CONF_DIR / arms.FILE).read_text(encoding="utf-8").partition("arms:")[0]
    (tmp_path / arms.FILE).write_text(f"{text}arms:\n  {entry}\n", encoding="utf-8")
    monkeypatch.setattr(arms, "CONF_DIR", tmp_path)
    if fits:
        assert len(read_zoo({})[1]) == 1
        return
    with pytest.raises(ConfigError, match=r"arm (g|G)uest must be small letters"):
        read_zoo({})
