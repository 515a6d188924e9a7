"""Following a path that is known: what one attempt loses others find, and nothing jumps."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import AbilityError, InitialError, PoseError, SettingError
from baselines.followed_path import FollowedPath
from baselines.following import FollowingSolver
from pipeline import load_solver
from robots import Robot, load_robot
from robots.rotations import rotation_angle
from tests.small_arms import arm, save

JUMP = 0.1
# Start, middle and end of motions of a Panda whose path one attempt loses, and where it does.
LOST = [
    (
        133,
        [0.81, -0.09, 2.16, -0.34, -0.25, 1.8, 2.26],
        [0.92, 0.18, 2.22, -0.46, -0.37, 1.6, 2.5],
        [1.08, 0.16, 2.5, -0.73, -0.63, 1.69, 2.38],
    ),
    (
        73,
        [1.05, -0.5, -2.04, -0.76, -0.06, 1.52, -1.56],
        [1.16, -0.4, -2.24, -0.48, -0.19, 1.64, -1.5],
        [1.39, -0.29, -2.3, -0.22, -0.48, 1.39, -1.83],
    ),
]


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="module", params=["lm", "cycleik_refined"])
def solver(request: pytest.FixtureRequest, panda: Robot) -> FollowingSolver:
    return loaded(request.param, panda)


def loaded(name: str, robot: Robot, **settings: object) -> FollowingSolver:
    found = load_solver(name, robot, **settings)  # type: ignore[arg-type]
    assert isinstance(found, FollowingSolver)
    return found


def motion(start: list[float], middle: list[float], end: list[float]) -> np.ndarray:
    """A parabola through three configurations, driven with minimum jerk at 100 Hz."""
    a, m, b = (np.array(q) for q in (start, middle, end))
    t = np.arange(149) / 148
    place = (2 * t**3 * (10 + t * (6 * t - 15)) - 1)[:, None]
    return np.asarray(m + (b - a) / 2 * place + ((a + b) / 2 - m) * place**2)


def check(robot: Robot, path: FollowedPath, poses: np.ndarray, start: np.ndarray) -> None:
    """What is reached is exact, inside the limits and without a jump; the rest is left open."""
    kept = path.joints[: path.reached]
    tips = robot.forward_kinematics(kept)
    assert np.linalg.norm(tips[:, :3] - poses[: len(kept), :3], axis=1).max() <= 1.001e-4
    assert rotation_angle(tips[:, 3:], poses[: len(kept), 3:]).max() <= 1.001e-4
    assert robot.within_limits(kept).all()
    assert np.abs(np.diff(kept, axis=0, prepend=start[None])).max() <= JUMP + 1e-9
    assert np.isnan(path.joints[path.reached :]).all()
    assert path.joints.shape == (len(poses), robot.dof)


@pytest.mark.parametrize(("where", "start", "middle", "end"), LOST)
def test_what_one_attempt_loses_others_find(
    solver: FollowingSolver,
    panda: Robot,
    where: int,
    start: list[float],
    middle: list[float],
    end: list[float],
) -> None:
    known = motion(start, middle, end)
    poses = panda.forward_kinematics(known)
    once = solver.follow_path(poses, known[0], attempts=1)
    assert not once.complete
    assert once.attempts == 1
    assert abs(once.reached - where) <= 5
    check(panda, once, poses, known[0])
    path = solver.follow_path(poses, known[0])
    assert path.complete
    assert 1 < path.attempts <= 16
    check(panda, path, poses, known[0])
    again = solver.follow_path(poses, known[0])
    np.testing.assert_array_equal(again.joints, path.joints)


def test_one_attempt_is_what_is_followed_pose_by_pose(panda: Robot) -> None:
    solver = loaded("lm", panda, max_jump=JUMP)
    rng = np.random.default_rng(3)
    for start in panda.sample(5, seed=3):
        target = np.clip(start + rng.uniform(-0.3, 0.3, 7), panda.lower, panda.upper)
        poses = panda.forward_kinematics(np.linspace(start, target, 60))
        path = solver.follow_path(poses, start, max_jump=JUMP, attempts=1)
        last, joints = start, []
        for pose in poses[: path.reached]:
            last, found = solver.follow_one(pose, last)
            assert found
            joints.append(last)
        np.testing.assert_array_equal(path.joints[: path.reached], joints)


def test_a_path_that_leaves_the_reach_is_followed_to_its_edge(panda: Robot) -> None:
    start = panda.home
    poses = np.repeat(panda.forward_kinematics(start[None]), 100, axis=0)
    poses[:, 0] += np.linspace(0.0, 1.0, 100)
    path = loaded("lm", panda).follow_path(poses, start, attempts=6)
    assert path.attempts == 6
    assert 10 < path.reached < 90
    check(panda, path, poses, start)


def test_a_first_pose_beyond_a_jump_is_not_reached(panda: Robot) -> None:
    known = panda.sample(2, seed=1)
    path = loaded("lm", panda).follow_path(panda.forward_kinematics(known[1:]), known[0])
    assert (path.reached, path.complete) == (0, False)
    assert np.isnan(path.joints).all()


@pytest.mark.parametrize(("name", "gain"), [("nico", 0.7), ("panda", 0.0)])
def test_an_arm_with_one_way_begins_once(name: str, gain: float) -> None:
    robot = load_robot(name)
    solver = loaded("lm", robot, null_space=gain)
    start = robot.home
    poses = robot.forward_kinematics(start + np.linspace(0, 3, 80)[:, None] * np.ones(robot.dof))
    path = solver.follow_path(poses, start)
    assert not path.complete
    assert path.attempts == 1


def test_an_endless_joint_turns_on(tmp_path: Path) -> None:
    text = arm(7, limit='<limit lower="-2" upper="2" velocity="1" effort="1"/>')
    text = text.replace('name="j1" type="revolute"', 'name="j1" type="continuous"')
    robot = load_robot(urdf=save(tmp_path, text))
    start = np.full(7, 0.4)
    turns = start + np.outer(np.linspace(0.0, 9.0, 400), np.eye(7)[0])
    path = loaded("lm", robot).follow_path(robot.forward_kinematics(turns), start)
    assert path.complete
    assert np.abs(np.diff(path.joints, axis=0)).max() <= JUMP
    assert path.joints[-1, 0] > 2 * np.pi


def test_wrong_input_is_refused_by_name(panda: Robot) -> None:
    solver = loaded("lm", panda)
    poses = panda.forward_kinematics(panda.home[None])
    with pytest.raises(PoseError, match="one pose or more"):
        solver.follow_path(np.empty((0, 7)), panda.home)
    with pytest.raises(PoseError):
        solver.follow_path(poses[0], panda.home)
    for start in (panda.home[:-1], np.full(7, np.nan), 1.0, panda.home[None]):
        with pytest.raises(InitialError):
            solver.follow_path(poses, start)
    for jump in (0.0, -1.0, np.nan, np.inf, "far"):
        with pytest.raises(SettingError, match="max_jump"):
            solver.follow_path(poses, panda.home, max_jump=jump)  # type: ignore[arg-type]
    for count in (0, -1, 1.5):
        with pytest.raises(SettingError, match="attempts"):
            solver.follow_path(poses, panda.home, attempts=count)  # type: ignore[arg-type]
    with pytest.raises(AbilityError, match="'bio_ik' has no follow"):
        baselines.load("bio_ik", panda).follow_path(poses, panda.home)
