import importlib.metadata
from pathlib import Path

import numpy as np
import pytest

from robots import Robot, RobotError, load_robot
from robots.add import add_robot
from robots.description import find_description

ELSEWHERE = [
    ("ur_description/urdf/ur5_robot.urdf", "base_link", "tool0", 6),
    ("tiago_description/robots/tiago_no_hand.urdf", "torso_fixed_link", "arm_tool_link", 8),
    ("talos_data/robots/talos_reduced.urdf", "torso_2_link", "gripper_left_base_link", 7),
    ("kinova_description/robots/kinova.urdf", "base", "j2s6s200_end_effector", 6),
]


def test_added_robot_is_the_same_robot(tmp_path: Path, two_link_urdf: Path) -> None:
    mixed = two_link_urdf.with_name("mixed.urdf")
    report = add_robot(mixed, "bench", "tool", name="My Robot", into=tmp_path, conf=tmp_path / "c")
    assert report.name == "my_robot"
    added = Robot(find_description("my_robot", tmp_path))
    given = load_robot(urdf=mixed, base="bench", tip="tool")
    joints = given.sample(100, collision_free=False)
    first, second = given.forward_kinematics(joints), added.forward_kinematics(joints)
    assert np.abs(first - second).max() < 1e-14
    assert np.array_equal(given.in_collision(joints), added.in_collision(joints))
    assert not added.in_collision(added.home)[0]
    text = str(report)
    for word in ("zero width", "no inertia", "mimic", "turn without end", "finger", "hand"):
        assert word in text


def test_config_has_the_form_of_the_others(tmp_path: Path, two_link_urdf: Path) -> None:
    import yaml

    report = add_robot(two_link_urdf, "base", "tip", into=tmp_path, conf=tmp_path / "c")
    values = yaml.safe_load(report.config.read_text())
    panda = Path(__file__).parents[3] / "conf" / "robot" / "panda.yaml"
    expected = yaml.safe_load(panda.read_text())
    assert values.keys() == expected.keys() and values["name"] == "two_link"


def test_taken_or_impossible_names_leave_nothing(tmp_path: Path, two_link_urdf: Path) -> None:
    add_robot(two_link_urdf, "base", "tip", into=tmp_path, conf=tmp_path / "c")
    before = sorted(tmp_path.rglob("*"))
    for name in ("two_link", "2", "//"):
        with pytest.raises(RobotError):
            add_robot(two_link_urdf, "base", "tip", name, tmp_path, tmp_path / "c")
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(("file", "base", "tip", "dof"), ELSEWHERE)
def test_robots_that_nobody_here_wrote(
    file: str, base: str, tip: str, dof: int, tmp_path: Path
) -> None:
    try:
        package = importlib.metadata.distribution("example-robot-data")
    except importlib.metadata.PackageNotFoundError:
        pytest.skip("example-robot-data is not installed")
    path = Path(str(package.locate_file("cmeel.prefix/share/example-robot-data/robots"))) / file
    report = add_robot(path, base, tip, name="guest", into=tmp_path, conf=tmp_path / "c")
    robot = Robot(find_description(report.name, tmp_path))
    assert robot.dof == dof
    joints = robot.sample(20)
    given = load_robot(urdf=path, base=base, tip=tip)
    difference = robot.forward_kinematics(joints) - given.forward_kinematics(joints)
    assert np.abs(difference).max() < 1e-12


# The tip's ball lies in the base's wall at zero, and nowhere near it when the arm is turned away.
WALL = """<robot name="walled">
<link name="base"><collision><origin xyz="0.8 0 0"/><geometry><box size="0.2 0.2 0.2"/></geometry>
</collision></link>
<link name="upper"><collision><origin xyz="0.2 0 0"/><geometry><sphere radius="0.05"/></geometry>
</collision></link>
<link name="tip"><collision><origin xyz="0.4 0 0"/><geometry><sphere radius="0.05"/></geometry>
</collision></link>
<joint name="first" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
<joint name="second" type="revolute"><parent link="upper"/><child link="tip"/>
<origin xyz="0.4 0 0"/><axis xyz="0 0 1"/>
<limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
</robot>"""


def test_a_home_that_collides_is_moved_to_a_sample_that_is_known_to_be_free(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "walled.urdf"
    path.write_text(WALL)
    drawn: list[bool] = []
    sample = Robot.sample

    def counted(robot: Robot, count: int, seed: int = 0, collision_free: bool = True) -> np.ndarray:
        drawn.append(collision_free)
        return sample(robot, count, seed, collision_free)

    monkeypatch.setattr(Robot, "sample", counted)
    report = add_robot(path, "base", "tip", into=tmp_path / "r", conf=tmp_path / "c")
    assert not any(drawn)  # free ones are searched for minutes where shapes are many
    robot = Robot(find_description(report.name, tmp_path / "r"))
    assert robot.in_collision(np.zeros((1, 2)))[0] and not robot.in_collision(robot.home[None])[0]
    assert np.linalg.norm(robot.home) < 1.0
    assert "base and tip touch, so home is the nearest free sample" in str(report)


def test_a_name_longer_than_a_file_name_may_be_is_refused(
    tmp_path: Path, two_link_urdf: Path
) -> None:
    for name in ("a" * 300, "é" * 60):
        with pytest.raises(RobotError, match="give a shorter --name"):
            add_robot(two_link_urdf, "base", "tip", name, tmp_path / "r", tmp_path / "c")
    assert not (tmp_path / "r").exists() and not (tmp_path / "c").exists()
