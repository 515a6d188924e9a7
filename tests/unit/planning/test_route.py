"""Another curve where the joints cannot follow the requested one."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import baselines
from pipeline.planning.continuity import Ends, branch_flips, kernel_options
from pipeline.planning.joint_space_candidates import joint_space_candidates
from pipeline.planning.motion import Motion, plan_motion
from pipeline.planning.path import tip_path
from pipeline.planning.route import find_route
from robots import Robot, load_robot
from robots.rotations import rotation_angle

NICO = load_robot("nico")
LM = baselines.load("lm", NICO)
OPTIONS = kernel_options(LM)
assert OPTIONS is not None
JOINTS = NICO.sample(24, seed=1)[:2]  # of a straight path in reach without continuous joints
ENDS = NICO.forward_kinematics(JOINTS)


def assert_driven(robot: Robot, motion: Motion) -> None:
    assert motion.route is not None
    assert motion.found.all()
    assert motion.flips == 0
    assert not branch_flips(robot, motion.joints, motion.poses).any()
    assert motion.tip_error_mm.max() < 0.2
    assert motion.tip_error_deg.max() < 0.02
    assert (motion.joints >= robot.lower).all()
    assert (motion.joints <= robot.upper).all()
    ends, requested = motion.poses[[0, -1]], motion.requested[[0, -1]]
    assert_allclose(ends[:, :3], requested[:, :3], atol=1e-9)
    assert rotation_angle(ends[:, 3:], requested[:, 3:]).max() < 1e-7


def test_a_path_without_a_branch_is_left_for_a_curve_that_has_one() -> None:
    motion = plan_motion(NICO, LM, *ENDS)
    assert_driven(NICO, motion)
    assert_allclose(motion.requested, tip_path(*ENDS))
    assert np.abs(motion.poses - motion.requested).max() > 0.01


def test_the_other_curve_is_one_of_control_points() -> None:
    motion = plan_motion(NICO, LM, *ENDS)
    assert motion.route is not None
    points, rotations = motion.route.control_points, motion.route.control_rotations
    again = tip_path(*ENDS, points, 50, rotations)
    assert_allclose(motion.poses[:, :3], again[:, :3], atol=1e-12)
    cosine = np.abs(np.sum(motion.poses[:, 3:] * again[:, 3:], axis=1))
    assert_allclose(cosine, 1.0, atol=1e-12)


def test_a_caller_can_forbid_it() -> None:
    motion = plan_motion(NICO, LM, *ENDS, reroute=False)
    assert motion.route is None
    assert motion.found.all()
    assert motion.flips > 0
    assert_allclose(motion.poses, motion.requested)


def test_the_branch_of_given_joints_is_kept() -> None:
    motion = plan_motion(NICO, LM, start_joints=JOINTS[0], target_joints=JOINTS[1])
    assert_driven(NICO, motion)
    assert_allclose(motion.joints[[0, -1]], JOINTS, atol=1e-12)


def test_a_path_that_leaves_the_reach_goes_another_way_if_its_ends_do_not() -> None:
    begin, end = NICO.home.copy(), NICO.home.copy()
    begin[0], end[0] = np.clip([-2.0, 2.0], NICO.lower[0], NICO.upper[0])
    start, target = NICO.forward_kinematics(np.array([begin, end]))
    away = np.array([0.5 * (start + target)[:3] + [3.0, 0.0, 0.0]])
    stays = plan_motion(NICO, LM, start, target, away, reroute=False)
    assert not stays.found.all()
    assert_driven(NICO, plan_motion(NICO, LM, start, target, away))


def test_an_end_out_of_reach_has_no_route() -> None:
    start, target = ENDS
    far = target + 3.0 * np.eye(7)[0]
    assert find_route(NICO, tip_path(start, far), Ends(None, None), OPTIONS) is None
    assert plan_motion(NICO, LM, start, far).route is None


@pytest.mark.parametrize("name", ["nico", "nicol"])
def test_ways_keep_the_limits_and_those_free_of_collisions_come_first(name: str) -> None:
    robot = load_robot(name)
    options = kernel_options(baselines.load("lm", robot))
    assert options is not None
    first, last = robot.forward_kinematics(robot.sample(2, seed=1))
    every = list(joint_space_candidates(robot, tip_path(first, last), Ends(None, None), options))
    assert every
    hits = np.array([robot.in_collision(candidate).any() for candidate in every])
    assert (np.diff(hits.astype(int)) >= 0).all()
    for candidate in every:
        assert (candidate >= robot.lower - 1e-9).all()
        assert (candidate <= robot.upper + 1e-9).all()
        assert np.abs(np.diff(candidate, axis=0)).max() < 0.5
