"""The proof of a "no": right where a hand can compute it, and never said of what is reached."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import baselines
from baselines import Budget
from robots import Robot, available_robots, load_robot
from robots.pose_bound import pose_bound, proven_rows, proves_no
from robots.reach_bound import reach_bound

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture(scope="module")
def two_link() -> Robot:
    """Links of 0.4 and 0.3 m that turn about z, the shoulder at the origin."""
    return load_robot(urdf=FIXTURES / "two_link.urdf")


def planar(x: float, y: float, yaw: float) -> NDArray[np.float64]:
    """A pose of the arm's plane, at the height of its shoulder."""
    return np.array([x, y, 0.1, np.cos(yaw / 2), 0, 0, np.sin(yaw / 2)])


def test_two_links_reach_as_far_as_they_are_long(two_link: Robot) -> None:
    bound = pose_bound(two_link)
    np.testing.assert_allclose(bound.radii, [0.7, 0.4], atol=1e-6)
    np.testing.assert_allclose(bound.points, [[0, 0, 0], [-0.3, 0, 0]], atol=1e-9)
    assert proves_no(bound, planar(0.7001, 0.0, 0.0), 0.0, 0.0)
    assert not proves_no(bound, planar(0.7, 0.0, 0.0), 0.0, 0.0)
    assert not proves_no(bound, planar(0.7001, 0.0, 0.0), 2e-4, 0.0)


def test_an_orientation_that_puts_the_elbow_out_of_reach_is_denied(two_link: Robot) -> None:
    """The tip at (0.4, 0.3): turned by 90 deg the elbow is at (0.4, 0), by 180 at (0.7, 0.3)."""
    bound = pose_bound(two_link)
    assert not proves_no(bound, planar(0.4, 0.3, np.pi / 2), 0.0, 0.0)
    assert proves_no(bound, planar(0.4, 0.3, np.pi), 0.0, 0.0)
    # By 91 deg the elbow is 0.0052 m further out; a tolerance of 1 deg takes that back.
    off = planar(0.4, 0.3, np.pi / 2 + np.pi / 180)
    assert proves_no(bound, off, 0.0, 0.0)
    assert not proves_no(bound, off, 0.0, 1.01 * np.pi / 180)


@pytest.mark.parametrize("name", [*available_robots(), "mixed"])
def test_no_pose_of_a_configuration_is_denied(name: str) -> None:
    mixed = FIXTURES / "mixed.urdf"  # sliding and coupled joints
    robot = load_robot(urdf=mixed, tip="tool") if name == "mixed" else load_robot(name)
    poses = robot.forward_kinematics(robot.sample(4000, seed=2, collision_free=False))
    denied = np.ones(len(poses), dtype=bool)
    proven_rows(pose_bound(robot), poses, 0.0, 0.0, denied)
    assert not denied.any()


@pytest.mark.parametrize("name", available_robots())
def test_the_quick_search_for_a_bound_is_about_as_good_as_the_thorough_one(name: str) -> None:
    robot = load_robot(name)
    assert pose_bound(robot).radii[0] <= reach_bound(robot).radius_m + 2e-3


def test_lm_says_a_proven_no_after_few_descents_alone_and_in_a_batch() -> None:
    robot = load_robot("panda")
    poses = robot.forward_kinematics(robot.sample(6, seed=3, collision_free=False))
    poses[1::2, 0] += 2.0
    solver = baselines.load("lm", robot)
    starts = solver.settings["nearest_starts"]
    batch = solver.solve(poses)
    assert batch.found.tolist() == [True, False] * 3
    assert set(batch.reason[1::2]) == {"proven out of reach"}
    for row, pose in enumerate(poses):
        alone = solver.solve(pose[None])
        assert np.array_equal(alone.joints[0], batch.joints[row])
        assert alone.reason == batch.reason[row : row + 1]
        assert alone.iterations[0] == batch.iterations[row]
    timed = solver.solve(poses[1::2], budget=Budget(time_s=10.0))
    assert set(timed.reason) == {"proven out of reach"}
    assert timed.time_s.max() < 1.0
    searching = baselines.load("lm", robot, nearest_starts=0)
    assert set(searching.solve(poses[1::2]).reason) == {"out of iterations"}
    distances = [
        np.linalg.norm(robot.forward_kinematics(each.joints)[:, :3] - poses[1::2, :3], axis=1)
        for each in (timed, searching.solve(poses[1::2]))
    ]
    assert starts > 1
    np.testing.assert_allclose(*distances, rtol=0.1)  # they trade distance for rotation
