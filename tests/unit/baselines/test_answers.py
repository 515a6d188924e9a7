"""Many solutions of a pose, counted by hand, and reasons for poses whose cause is known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import PoseError, SettingError, SkippedSolver
from baselines.distinct import distinct, joint_distances
from robots import Robot, load_robot
from robots.rotations import quaternion_from_rotation_vector, quaternion_multiply
from tests.planar import planar
from tests.small_arms import arm, save

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


def pose_of(robot: Robot, *joints: float) -> np.ndarray:
    return robot.forward_kinematics(np.array([joints]))[0]


@pytest.mark.parametrize(
    ("lengths", "limit", "kind", "joints", "count"),
    [
        ((0.4, 0.3, 0.2), 3.0, "revolute", (0.3, 0.8, -0.5), 2),  # elbow up and down
        ((0.4, 0.3, 0.2), 0.9, "revolute", (0.3, 0.8, -0.5), 1),  # the other one is at 0.98 rad
        ((0.4, 0.3), 3.0, "revolute", (0.3, 0.8), 1),  # no joint is left for the orientation
        ((0.5,), 9.5, "revolute", (0.4,), 3),  # a turn less and a turn more
        ((0.5,), 9.5, "continuous", (0.4,), 1),  # which are the same where it turns for ever
        ((0.4, 0.3, 0.2), 3.0, "continuous", (0.3, 3.0, -0.5), 2),
    ],
)
def test_a_planar_arm_has_so_many_solutions(
    lengths: tuple[float, ...],
    limit: float,
    kind: str,
    joints: tuple[float, ...],
    count: int,
    tmp_path: Path,
) -> None:
    robot = planar(tmp_path, lengths, limit, kind)
    pose = pose_of(robot, *joints)
    found = baselines.load("lm", robot).solve_all(pose, 10, apart=0.05)
    assert len(found) == count
    assert joint_distances(robot, found, np.array(joints)).min() < 1e-3
    reached = robot.forward_kinematics(found)
    assert np.linalg.norm(reached[:, :3] - pose[:3], axis=1).max() < 1.1e-4


def test_the_elbow_is_mirrored_and_the_nearest_comes_first(tmp_path: Path) -> None:
    """Both elbows: q2 changes its sign, q1 turns by twice the angle between link and wrist."""
    robot = planar(tmp_path, (0.4, 0.3, 0.2))
    up = np.array([0.3, 0.8, -0.5])
    inner = np.arctan2(0.3 * np.sin(0.8), 0.4 + 0.3 * np.cos(0.8))
    down = np.array([0.3 + 2 * inner, -0.8, up.sum() - 0.3 - 2 * inner + 0.8])
    solver = baselines.load("lm", robot)
    for first, second in ((up, down), (down, up)):
        found = solver.solve_all(pose_of(robot, *up), 5, apart=0.05, initial=first + 0.1)
        assert np.allclose(found, [first, second], atol=2e-3)
    again = solver.solve_all(pose_of(robot, *up), 5, apart=0.05, initial=down)
    assert np.array_equal(again, solver.solve_all(pose_of(robot, *up), 5, apart=0.05, initial=down))
    assert len(solver.solve_all(pose_of(robot, *up), 1, apart=0.05)) == 1
    assert solver.solve_all(np.array([2.0, 0, 0, 1, 0, 0, 0]), 5, apart=0.05).shape == (0, 3)


@pytest.mark.parametrize("name", ["lm", "lookup", "frankik", "ssik"])
def test_solutions_of_the_panda_are_solutions_and_apart(name: str) -> None:
    robot = load_robot("panda")
    try:
        solver = baselines.load(name, robot, **({"remembered": 500} if name == "lookup" else {}))
    except SkippedSolver as reason:
        pytest.skip(str(reason))
    pose = robot.forward_kinematics(robot.sample(1, seed=3))[0]
    found = solver.solve_all(pose, 12, apart=0.2, initial=robot.home)
    assert 2 <= len(found) <= 12
    assert robot.within_limits(found).all()
    assert np.abs(robot.forward_kinematics(found) - pose)[:, :3].max() < 1.1e-4
    assert len(distinct(robot, found, 0.2)) == len(found)
    away = np.abs(found - robot.home).max(axis=1)
    assert (np.diff(away) >= 0.0).all()


def test_what_cannot_be_asked_is_refused(tmp_path: Path) -> None:
    robot = planar(tmp_path, (0.4, 0.3))
    solver, pose = baselines.load("lm", robot), pose_of(robot, 0.1, 0.2)
    with pytest.raises(SettingError, match="count to be at least 1"):
        solver.solve_all(pose, 0, apart=0.1)
    with pytest.raises(SettingError, match="apart to be a finite number above 0"):
        solver.solve_all(pose, 3, apart=0.0)
    with pytest.raises(PoseError, match=r"one finite pose of shape \(7,\)"):
        solver.explain(pose[None])


def test_beyond_reach_by_ten_millimetres() -> None:
    robot = load_robot(urdf=TWO_LINK)
    pose = np.array([0.0, 0.71, 0.1, np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    told = baselines.load("lm", robot).explain(pose)
    assert told.reason == "out of reach"
    assert told.beyond_reach_m == pytest.approx(0.01, abs=3e-4)
    assert told.distance_m == pytest.approx(0.01, abs=3e-4)
    assert not (told.position_alone or told.limits_lifted)
    assert told.sentence.startswith("The place is 9.")


def test_behind_a_limit() -> None:
    """The shoulder would have to be 0.1 rad beyond its 3 rad; the place has the other elbow."""
    robot = load_robot(urdf=TWO_LINK)
    inside = np.array([3.1, 0.5])
    told = baselines.load("lm", robot).explain(robot.forward_kinematics(inside[None])[0])
    assert told.reason == "limits"
    assert told.position_alone and told.limits_lifted
    assert told.excess == pytest.approx([0.1, 0.0], abs=2e-3)
    assert "beyond the limits of shoulder by 5.7" in told.sentence
    assert "elbow" not in told.sentence


def test_an_orientation_that_three_joints_do_not_have(tmp_path: Path) -> None:
    robot = load_robot(urdf=save(tmp_path, arm(3)))
    pose = robot.forward_kinematics(robot.home[None])[0]
    turn = quaternion_from_rotation_vector(np.array([0.6, -0.7, 0.5]))
    pose[3:] = quaternion_multiply(pose[3:], turn)
    told = baselines.load("lm", robot).explain(pose)
    assert told.reason == "orientation"
    assert told.position_alone and not told.limits_lifted
    assert told.position_distance_m < 1.1e-4
    assert told.angle_rad > 0.05 or told.distance_m > 1e-3


def test_a_pose_that_has_a_solution_is_said_to_have_one() -> None:
    robot = load_robot("panda")
    pose = robot.forward_kinematics(robot.sample(1, seed=8))[0]
    told = baselines.load("lm", robot).explain(pose)
    assert told.reason == "reachable"
    assert np.allclose(robot.forward_kinematics(told.joints)[0, :3], pose[:3], atol=1.1e-4)
