import numpy as np
import pytest
from numpy.testing import assert_allclose

import baselines
from pipeline.planning.config import MotionConfig
from pipeline.planning.control import control_points
from pipeline.planning.motion import plan_motion
from pipeline.planning.path import tip_path
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
    motion = plan_motion(ROBOT, SOLVER, WAY[0], TARGET)
    assert_allclose(motion.joints[0], WAY[0])
    assert_allclose(motion.poses[0], START)


def test_target_joints_are_the_last_waypoint():
    motion = plan_motion(ROBOT, SOLVER, START, WAY[1])
    assert_allclose(motion.joints[-1], WAY[1])
    assert_allclose(motion.poses[-1], TARGET)


def test_out_of_reach_is_reported_not_raised():
    motion = plan_motion(ROBOT, SOLVER, START, START + 3.0 * np.eye(7)[0])
    assert motion.found[0]
    assert not motion.found[-1]
    assert motion.tip_error_mm[-1] > 1000


@pytest.mark.parametrize("bad", [np.zeros(3), np.full(7, np.nan), np.zeros(5), np.zeros((2, 7))])
def test_neither_pose_nor_joints_is_refused(bad):
    with pytest.raises(ValueError, match="start must be a pose"):
        plan_motion(ROBOT, SOLVER, bad, TARGET)


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
