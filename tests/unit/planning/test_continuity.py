"""Flips, and how paths without them are found, on arms whose branches are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose

import baselines
from pipeline.planning.continuity import (
    Answers,
    Ends,
    branch_flips,
    joint_steps,
    kernel_options,
    repair_path,
)
from pipeline.planning.motion import plan_motion
from pipeline.planning.path import tip_path
from pipeline.planning.reach import judge_path
from pipeline.planning.search import QUICK, fewest_flips, longest_path, one_branch, solutions
from robots import load_robot

FREE = Ends(None, None)
NICO, NICOL, PANDA = load_robot("nico"), load_robot("nicol"), load_robot("panda")
OPTIONS = kernel_options(baselines.load("lm", PANDA))
BEND = np.array([0.4, -0.3, 0.3, 0.3, -0.2, 0.4, 0.3])


def joint_way(robot, bend, steps=50):
    """A smooth path of joints from home inside the limits, and the poses that it runs through."""
    k = np.linspace(0.0, 1.0, steps)[:, None]
    end = np.clip(robot.home + bend, robot.lower + 0.1, robot.upper - 0.1)
    joints = robot.home + k * (end - robot.home)
    return joints, robot.forward_kinematics(joints)


def tip_error_mm(robot, joints, poses):
    return 1e3 * np.abs(robot.forward_kinematics(joints)[:, :3] - poses[:, :3]).max()


def another_branch(robot, pose, joints):
    """A solution of a pose that is far from the given one."""
    found = solutions(robot, pose, OPTIONS, QUICK)
    return found[np.argmax(np.abs(found - joints).max(axis=1))]


def test_a_smooth_path_has_no_flip_and_another_branch_is_one():
    joints, poses = joint_way(PANDA, BEND)
    assert not branch_flips(PANDA, joints, poses).any()
    jumped = joints.copy()
    jumped[20] = another_branch(PANDA, poses[20], joints[20])
    assert list(np.flatnonzero(branch_flips(PANDA, jumped, poses))) == [19, 20]


def test_a_wide_step_along_the_path_is_no_flip_however_coarse_the_path():
    joints, poses = joint_way(PANDA, 3.0 * BEND, steps=3)
    assert joint_steps(joints).max() > 0.5
    assert not branch_flips(PANDA, joints, poses).any()


def test_a_turn_of_the_wrist_that_the_path_does_not_make_is_a_flip():
    joints = np.stack([PANDA.home, PANDA.home + 0.6 * np.eye(7)[6]])
    still = PANDA.forward_kinematics(joints[[0, 0]])
    turned = PANDA.forward_kinematics(joints)
    # The last axis runs through the tip: its position says nothing.
    assert np.linalg.norm(turned[0, :3] - turned[1, :3]) < 1e-9
    assert branch_flips(PANDA, joints, still)[0]
    assert not branch_flips(PANDA, joints, turned)[0]


def test_a_smooth_path_is_left_as_it_was():
    joints, poses = joint_way(PANDA, BEND)
    found = np.ones(50, dtype=bool)
    assert repair_path(PANDA, poses, Answers(joints, found), FREE, OPTIONS)[0] is joints


@pytest.mark.parametrize("robot", [NICOL, PANDA], ids=lambda robot: robot.name)
def test_a_path_that_changes_its_branch_is_mended(robot):
    joints, poses = joint_way(robot, np.resize(BEND, robot.dof))
    broken = joints.copy()
    broken[10:18] = [another_branch(robot, poses[i], joints[i]) for i in range(10, 18)]
    assert branch_flips(robot, broken, poses).any()
    claims = Answers(broken, np.ones(50, dtype=bool))
    path, found = repair_path(robot, poses, claims, FREE, OPTIONS)
    assert found.all()
    assert not branch_flips(robot, path, poses).any()
    assert tip_error_mm(robot, path, poses) < 0.2
    assert (path >= robot.lower).all()
    assert (path <= robot.upper).all()


def test_given_joints_stay_at_both_ends_and_a_redundant_arm_gets_from_one_to_the_other():
    joints, poses = joint_way(PANDA, BEND)
    broken = joints.copy()
    broken[25] = another_branch(PANDA, poses[25], joints[25])
    ends = Ends(joints[0], joints[-1])
    claims = Answers(broken, np.ones(50, dtype=bool))
    path, found = repair_path(PANDA, poses, claims, ends, OPTIONS)
    assert_allclose(path[[0, -1]], joints[[0, -1]])
    assert found.all()
    assert not branch_flips(PANDA, path, poses).any()


def test_nothing_in_hand_but_the_poses_is_enough():
    _, poses = joint_way(NICO, BEND[:6])
    path = one_branch(NICO, poses, OPTIONS, QUICK)
    assert path is not None
    assert not branch_flips(NICO, path, poses).any()
    searched, found = fewest_flips(NICO, poses, OPTIONS, QUICK)
    assert found.all()
    assert not branch_flips(NICO, searched, poses).any()
    assert tip_error_mm(NICO, searched, poses) < 0.2
    again, _ = fewest_flips(NICO, poses, OPTIONS, QUICK)
    assert (again == searched).all()


def test_the_search_moves_in_the_null_space_towards_a_goal():
    joints, poses = joint_way(PANDA, np.zeros(7))
    elbow = longest_path(PANDA, poses, joints[:1], OPTIONS, QUICK)
    assert len(elbow) == 50
    others = solutions(PANDA, poses[0], OPTIONS, QUICK)
    near = np.abs(others - joints[0]).max(axis=1)
    goal = others[np.argmin(np.where(near > 0.3, near, np.inf))]
    path = longest_path(PANDA, poses, joints[:1], OPTIONS, QUICK, goal)
    assert np.abs(path[-1] - goal).max() < 0.5 * np.abs(joints[0] - goal).max()
    assert tip_error_mm(PANDA, path, poses) < 0.2


def test_a_path_out_of_reach_and_back_stays_near_without_a_jump():
    _, poses = joint_way(NICO, BEND[:6])
    poses[20:30, 0] += 2.0
    path, found = fewest_flips(NICO, poses, OPTIONS, QUICK)
    assert list(np.flatnonzero(~found)) == list(range(20, 30))
    assert joint_steps(path[:30]).max() < 0.5
    verdict = judge_path(NICO, poses, OPTIONS)
    assert not verdict.in_reach
    assert not verdict.continuous


def test_nothing_in_reach_is_no_error():
    _, poses = joint_way(NICO, BEND[:6])
    poses[:, 0] += 5.0
    path, found = fewest_flips(NICO, poses, OPTIONS, QUICK)
    assert not found.any()
    assert np.isfinite(path).all()


@pytest.mark.parametrize("robot", [NICO, PANDA], ids=lambda robot: robot.name)
def test_plans_flip_only_where_an_exhaustive_search_finds_no_other_way(robot):
    lm = baselines.load("lm", robot)
    configurations = robot.sample(16, seed=3)
    poses = robot.forward_kinematics(configurations)
    avoidable = 0
    for start, target in zip(poses[:8], poses[8:], strict=True):
        verdict = judge_path(robot, tip_path(start, target), OPTIONS)
        motion = plan_motion(robot, lm, start, target, reroute=False)
        assert verdict.in_reach == motion.found.all()
        avoidable += verdict.continuous and motion.flips > 0
        if motion.found.all():
            assert motion.tip_error_mm.max() < 0.2
    assert avoidable == 0
