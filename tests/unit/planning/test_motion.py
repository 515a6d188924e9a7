import numpy as np
import pytest
from numpy.testing import assert_allclose

import baselines
from pipeline.planning.config import MotionConfig
from pipeline.planning.motion import plan_motion
from pipeline.planning.path import PathError, control_points, tip_path
from robots import load_robot

ROBOT = load_robot("panda")
SOLVER = baselines.load("lm", ROBOT)
WAY = ROBOT.home + np.array([[0.0] * 7, [0.4, -0.3, 0.3, 0.3, -0.2, 0.4, 0.3]])
START, TARGET = ROBOT.forward_kinematics(WAY)


def test_fifty_poses_are_one_query_and_a_motion():
    motion = plan_motion(ROBOT, SOLVER, START, TARGET, steps=50)
    assert motion.poses.shape == (50, 7)
    assert motion.joints.shape == (50, 7)
    assert motion.found.all()
    assert motion.tip_error_mm.max() < 0.2
    assert motion.flips == 0
    assert motion.largest_step < 0.2
    assert 0 < motion.query_s <= motion.time_s


def test_start_joints_are_the_first_waypoint():
    motion = plan_motion(ROBOT, SOLVER, start_joints=WAY[0], target=TARGET)
    assert_allclose(motion.joints[0], WAY[0])
    assert_allclose(motion.poses[0], START)


def test_target_joints_are_the_last_waypoint():
    motion = plan_motion(ROBOT, SOLVER, START, target_joints=WAY[1])
    assert_allclose(motion.joints[-1], WAY[1])
    assert_allclose(motion.poses[-1], TARGET)


def test_out_of_reach_is_reported_not_raised():
    motion = plan_motion(ROBOT, SOLVER, START, START + 3.0 * np.eye(7)[0])
    assert motion.found[0]
    assert not motion.found[-1]
    assert motion.tip_error_mm[-1] > 1000


SHORT, JOINTS = np.zeros(3), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]


@pytest.mark.parametrize(
    "bad", [SHORT, np.full(7, np.nan), JOINTS, np.zeros((2, 7)), "here", [[0]]]
)
def test_what_is_no_pose_is_refused_by_name(bad):
    with pytest.raises(PathError, match="start must be"):
        plan_motion(ROBOT, SOLVER, bad, TARGET)
    with pytest.raises(PathError, match="target must be"):
        tip_path(START, bad)


@pytest.mark.parametrize("bad", [SHORT, np.full(7, np.inf), np.zeros((1, 7))])
def test_what_are_no_joints_is_refused_by_name(bad):
    with pytest.raises(PathError, match="target_joints must be the 7 joint positions"):
        plan_motion(ROBOT, SOLVER, START, target_joints=bad)


def test_seven_numbers_are_what_the_keyword_says():
    """On an arm of seven joints a pose is a joint vector by its shape alone."""
    moved = plan_motion(ROBOT, SOLVER, start_joints=TARGET, target=START)
    assert_allclose(moved.joints[0], TARGET)
    assert_allclose(moved.poses[0], ROBOT.forward_kinematics(TARGET[None])[0])
    assert_allclose(plan_motion(ROBOT, SOLVER, TARGET, START).poses[0], TARGET)


def test_each_end_is_given_once():
    with pytest.raises(PathError, match=r"start, a pose, or start_joints, got both"):
        plan_motion(ROBOT, SOLVER, START, TARGET, start_joints=WAY[0])
    with pytest.raises(PathError, match=r"target, a pose, or target_joints, got neither"):
        plan_motion(ROBOT, SOLVER, START)


@pytest.mark.parametrize(
    "bad", [np.zeros(3), np.zeros((2, 4)), [[0.1, np.nan, 0.2]], [[1], [2, 3]]]
)
def test_control_points_of_another_shape_are_refused_by_name(bad):
    with pytest.raises(PathError, match="control_points must"):
        plan_motion(ROBOT, SOLVER, START, TARGET, bad)


@pytest.mark.parametrize("bad", [[1.0, 0, 0, 0], [[1.0, 0, 0]], [[2.0, 0, 0, 0]]])
def test_key_rotations_of_another_shape_are_refused_by_name(bad):
    with pytest.raises(PathError, match="control_rotations must"):
        plan_motion(ROBOT, SOLVER, START, TARGET, control_rotations=bad)


def test_no_control_points_is_a_straight_line():
    assert_allclose(tip_path(START, TARGET, []), tip_path(START, TARGET))


LOW, OTHER = np.array([[0.6, 0.1, 0, 1, 0, 0, 0], [0.2, 0.6, 0, 1, 0, 0, 0]])


def test_approach_ends_vertically_and_clears_its_start():
    motion = MotionConfig("approach", 0.05, 1, 0.15, 3, 50, False)
    points = control_points(LOW, OTHER, motion)
    assert points.shape == (4, 3)
    path = tip_path(LOW, OTHER, points)[:, :3]
    low = path[:, 2] < 0.075
    sideways = np.linalg.norm(path[:, :2] - OTHER[:2], axis=1)
    last_leg = low & (np.arange(50) > 25)
    assert last_leg.sum() >= 5
    assert sideways[last_leg].max() < 0.01
    assert (path[:, 2] >= -1e-12).all()


def test_straight_rule_has_no_control_points():
    assert control_points(LOW, OTHER, MotionConfig("straight", 0.0, 0, 0.0, 0, 50, True)).shape == (
        0,
        3,
    )
