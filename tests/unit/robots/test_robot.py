import pickle
import shutil
from pathlib import Path

import numpy as np
import pytest

from robots import DescriptionError, Robot, RobotError, UnknownRobotError, load_robot
from robots.description import available_robots, find_description

DESCRIPTION = """
name: two_link
title: Two-link arm
urdf: two_link.urdf
base: base
tip: tip
joints: [shoulder, elbow]
lower: null
upper: [1.0, 2.0]
home: [0.5, 0.5]
workspace: {lower: [0.0, -0.5, 0.0], upper: [0.7, 0.5, 0.2]}
posture: {}
allowed_collisions: []
hand: null
"""


@pytest.fixture
def folder(tmp_path: Path, two_link_urdf: Path) -> Path:
    (tmp_path / "two_link").mkdir()
    shutil.copy(two_link_urdf, tmp_path / "two_link")
    (tmp_path / "two_link" / "robot.yaml").write_text(DESCRIPTION)
    return tmp_path


def load(folder: Path, old: str = "", new: str = "") -> Robot:
    (folder / "two_link" / "robot.yaml").write_text(DESCRIPTION.replace(old, new))
    return Robot(find_description("two_link", folder))


def test_description_is_applied(folder: Path) -> None:
    robot = load(folder)
    assert available_robots(folder) == ["two_link"]
    assert robot.lower.tolist() == [-3.0, -2.5] and robot.upper.tolist() == [1.0, 2.0]
    assert robot.home.tolist() == [0.5, 0.5] and robot.velocity_limit.tolist() == [2.0, 3.0]
    assert robot.workspace.tolist() == [[0.0, -0.5, 0.0], [0.7, 0.5, 0.2]]
    assert len(robot.urdf_checksum) == 64


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("hand: null", "hands: null", "unknown keys"),
        ("base: base", "", "missing"),
        ("[shoulder, elbow]", "[elbow, shoulder]", "URDF has"),
        ("[1.0, 2.0]", "[1.0, 2.6]", "wider than the URDF"),
        ("[1.0, 2.0]", "[1.0]", "one for each"),
        ("[1.0, 2.0]", "[-3.0, 2.0]", "not below the upper"),
        ("[1.0, 2.0]", "[one, 2.0]", "expected numbers"),
        ("[0.5, 0.5]", "[1.5, 0.5]", "does not fit the limits"),
        ("upper: [0.7, 0.5, 0.2]", "upper: [0.7, 0.5]", "workspace"),
        ("upper: [0.7, 0.5, 0.2]", "upper: [0.7, 0.5, -0.2]", "lower below upper"),
        ("posture: {}", "posture: {wrist: 1.0}", "no movable joints"),
        ("posture: {}", "posture: {elbow: fast}", "a number for each joint"),
        ("allowed_collisions: []", "allowed_collisions: [[a, b]]", r"\[link, link, reason\]"),
        ("hand: null", "hand: [", "not valid YAML"),
    ],
)
def test_wrong_description_is_refused(folder: Path, old: str, new: str, expected: str) -> None:
    with pytest.raises(DescriptionError, match=expected):
        load(folder, old, new)


def test_allowed_pair_must_exist(folder: Path) -> None:
    robot = load(folder, "allowed_collisions: []", "allowed_collisions: [[base, hand, always]]")
    with pytest.raises(DescriptionError, match="hand"):
        robot.in_collision(robot.home)


def test_posture_freezes_a_joint_of_the_chain(folder: Path) -> None:
    text = DESCRIPTION.replace("posture: {}", "posture: {shoulder: 0.3}")
    for old in ("joints: [shoulder, elbow]\n", "upper: [1.0, 2.0]\n", "home: [0.5, 0.5]\n"):
        text = text.replace(old, "")
    (folder / "two_link" / "robot.yaml").write_text(text)
    robot = Robot(find_description("two_link", folder))
    assert robot.joint_names == ("elbow",)
    whole = load(folder).forward_kinematics([0.3, 0.7])
    assert robot.forward_kinematics([0.7]) == pytest.approx(whole, abs=1e-15)


def test_unknown_robot_names_the_closest_and_all() -> None:
    with pytest.raises(UnknownRobotError, match="did you mean 'panda'") as caught:
        load_robot("pandaa")
    assert all(name in str(caught.value) for name in available_robots())


def test_load_robot_wants_one_source(two_link_urdf: Path) -> None:
    for arguments in ({}, {"name": "panda", "urdf": two_link_urdf}, {"name": "panda", "tip": "x"}):
        with pytest.raises(RobotError):
            load_robot(**arguments)


def test_a_robot_travels_between_processes(two_link: Robot) -> None:
    copy = pickle.loads(pickle.dumps(two_link))
    joints = two_link.sample(20)
    assert np.array_equal(copy.forward_kinematics(joints), two_link.forward_kinematics(joints))


def test_workspace_without_a_description_is_the_reach(two_link: Robot) -> None:
    assert two_link.workspace[1] == pytest.approx([0.7, 0.7, 0.1], abs=2e-3)
