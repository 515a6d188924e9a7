"""Self-motion: the tip stays, joints keep to their limits; no redundancy, no motion."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.viewing.errors import ViewError
from pipeline.viewing.null_space import self_motion
from robots import load_robot
from robots.rotations import rotation_angle

STEP = 0.02


@pytest.mark.parametrize(("name", "seed"), [("panda", 0), ("nicol", 1)])
def test_the_tip_stays_where_it_is_and_the_motion_closes(name: str, seed: int) -> None:
    robot = load_robot(name)
    joints = robot.sample(1, seed=3)[0]
    path = self_motion(robot, joints, STEP, seed)
    poses = robot.forward_kinematics(path)
    assert np.abs(poses[:, :3] - poses[0, :3]).max() < 1e-7
    assert rotation_angle(poses[:, 3:], poses[:1, 3:]).max() < 1e-6
    assert robot.within_limits(path).all()
    assert len(path) > 20
    assert np.abs(path - joints).max() > 5 * STEP
    assert (path[0] == joints).all()
    assert (path[-1] == joints).all()
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert steps.min() > 0.5 * STEP
    assert steps.max() < 1.5 * STEP


def test_another_seed_takes_another_direction_where_there_are_two() -> None:
    robot = load_robot("nicol")
    joints = robot.sample(1, seed=3)[0]
    first, second = (self_motion(robot, joints, STEP, seed)[1] - joints for seed in (0, 1))
    assert abs(first @ second) < 0.99 * np.linalg.norm(first) * np.linalg.norm(second)


def test_an_arm_of_six_joints_has_none() -> None:
    robot = load_robot("nico")
    with pytest.raises(ViewError, match=r"nico has 6 joints and no null space"):
        self_motion(robot, robot.sample(1, seed=3)[0], STEP)
