"""Joints that turn for ever: full turns make no difference, and no half turn is in the way."""

from pathlib import Path

import numpy as np
import pytest

import baselines
from robots import Robot, load_robot
from robots.add import add_robot
from robots.description import find_description
from robots.limits import FULL_TURN
from tests.small_arms import LIMIT, arm, save

# Solvers that stand on different libraries; the others share their loops.
SOLVERS = ("lm", "bio_ik", "pinocchio", "placo", "pink", "mink", "trac_ik", "pytorch_kinematics")
SOLVERS += ("optik", "roboticstoolbox")


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """Six joints, of which the first, third and sixth turn for ever."""
    text = arm(6, limit=LIMIT.replace('"-1"', '"-2"').replace('"1"', '"2"', 1))
    for name in ("j1", "j3", "j6"):
        text = text.replace(f'name="{name}" type="revolute"', f'name="{name}" type="continuous"')
    return load_robot(urdf=save(tmp_path_factory.mktemp("wheels"), text))


def test_which_joints_turn_for_ever(wheels: Robot) -> None:
    assert wheels.endless.tolist() == [True, False, True, False, False, True]
    assert wheels.lower[0] == -np.pi and wheels.upper[0] == np.pi
    assert load_robot("fetch").endless.sum() == 3  # pi is rounded in its robot.yaml
    assert not load_robot("panda").endless.any()


def test_full_turns_make_no_difference(wheels: Robot) -> None:
    joints = wheels.sample(200)
    turned = joints + FULL_TURN * wheels.endless * np.array([[1, 0, -2, 0, 0, 3]])
    difference = wheels.forward_kinematics(turned) - wheels.forward_kinematics(joints)
    assert np.abs(difference).max() < 1e-13
    assert np.array_equal(wheels.in_collision(turned), wheels.in_collision(joints))
    assert wheels.within_limits(turned).all()
    assert np.abs(wheels.nearest_turns(turned) - joints).max() < 1e-13
    assert np.abs(wheels.nearest_turns(joints, turned) - turned).max() < 1e-13
    joints[:, 1] = 2.5
    assert not wheels.within_limits(joints).any()


@pytest.mark.parametrize("name", SOLVERS)
def test_a_path_across_the_half_turn_is_followed(wheels: Robot, name: str) -> None:
    if reason := baselines.skip(name, wheels):
        pytest.skip(reason)
    solver = baselines.load(name, wheels)
    middle = np.array([np.pi, 0.4, -np.pi, 0.5, -0.6, 3.0])
    for turns in (0, 2):
        start = middle + FULL_TURN * turns * wheels.endless
        goal = start + 0.05
        found = solver.solve(wheels.forward_kinematics(goal), initial=start)
        assert found.found.all()
        assert np.abs(found.joints[0] - goal).max() < 0.01


@pytest.mark.parametrize("name", SOLVERS)
def test_answers_are_within_the_limits_or_within_half_a_turn(wheels: Robot, name: str) -> None:
    if reason := baselines.skip(name, wheels):
        pytest.skip(reason)
    poses = wheels.forward_kinematics(wheels.sample(20, seed=1))
    solver = baselines.load(name, wheels)
    plain = solver.solve(poses)
    assert ((plain.joints >= wheels.lower) & (plain.joints <= wheels.upper)).all()
    guess = np.array([20.0, 0.0, -3.0, 0.0, 0.0, 1e5])
    near = solver.solve(poses, initial=guess)
    assert wheels.within_limits(near.joints).all()
    assert np.abs(near.joints - guess)[:, wheels.endless].max() <= np.pi + 1e-9
    assert plain.found.mean() >= 0.4 and near.found.mean() >= 0.4


def test_an_added_robot_still_turns_for_ever(wheels: Robot, tmp_path: Path) -> None:
    add_robot(wheels.urdf_path, "b", "l6", "wheels", into=tmp_path / "r", conf=tmp_path / "c")
    added = Robot(find_description("wheels", tmp_path / "r"))
    assert np.array_equal(added.endless, wheels.endless)


def test_a_description_may_take_the_turning_away(wheels: Robot, tmp_path: Path) -> None:
    add_robot(wheels.urdf_path, "b", "l6", "wheels", into=tmp_path / "r", conf=tmp_path / "c")
    path = tmp_path / "r" / "wheels" / "robot.yaml"
    text = path.read_text().replace("upper: null", "upper: [3.14159, 2, 1.0, 2, 2, 3.2]")
    path.write_text(text)
    added = Robot(find_description("wheels", tmp_path / "r"))
    assert added.endless.tolist() == [True, False, False, False, False, True]
    assert added.upper[2] == 1.0 and added.upper[5] == np.pi
