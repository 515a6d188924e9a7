from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

from pipeline.planning.config import MotionConfig
from pipeline.planning.continuity import branch_flips
from pipeline.planning.control import control_points
from pipeline.planning.motion import plan_motion, tip_path

UP = np.array([1.0, 0.0, 0.0, 0.0])
LENGTHS = (0.5, 0.4)


class PlanarArm:
    """Two links in the plane, solved in closed form, so that each branch can be asked for."""

    name, dof = "planar", 2
    home = np.array([0.3, 0.8])

    def sample(self, n, seed=0, collision_free=True):
        return np.random.default_rng(seed).uniform(-np.pi, np.pi, size=(n, 2))

    def forward_kinematics(self, joints):
        q = np.atleast_2d(joints)
        total = q.sum(axis=1)
        x = LENGTHS[0] * np.cos(q[:, 0]) + LENGTHS[1] * np.cos(total)
        y = LENGTHS[0] * np.sin(q[:, 0]) + LENGTHS[1] * np.sin(total)
        zero = np.zeros_like(x)
        half = total / 2
        return np.stack([x, y, zero, np.cos(half), zero, zero, np.sin(half)], axis=1)


class Elbow:
    """Closed-form solver; `flip_from` sends every later waypoint to the other branch."""

    def __init__(self, flip_from=None):
        self.flip_from, self.calls = flip_from, []

    def solve(self, poses, initial=None, budget=None):
        self.calls.append(len(poses))
        x, y = poses[:, 0], poses[:, 1]
        cosine = (x**2 + y**2 - LENGTHS[0] ** 2 - LENGTHS[1] ** 2) / (2 * LENGTHS[0] * LENGTHS[1])
        bend = np.arccos(np.clip(cosine, -1, 1))
        if self.flip_from is not None:
            bend[self.flip_from :] *= -1
        first = np.arctan2(y, x) - np.arctan2(
            LENGTHS[1] * np.sin(bend), LENGTHS[0] + LENGTHS[1] * np.cos(bend)
        )
        return SimpleNamespace(joints=np.stack([first, bend], 1), found=np.abs(cosine) <= 1)


ROBOT = PlanarArm()
START = np.array([0.6, 0.1, 0.0, *UP])
TARGET = np.array([0.2, 0.6, 0.0, *UP])


def test_fifty_poses_are_one_query():
    solver = Elbow()
    motion = plan_motion(ROBOT, solver, START, TARGET, steps=50)
    assert solver.calls == [2, 50]  # its two ends, for seeds, then the whole path
    assert motion.poses.shape == (50, 7)
    assert motion.joints.shape == (50, 2)
    assert motion.found.all()
    assert motion.tip_error_mm.max() < 1e-9
    assert motion.flips == 0
    assert motion.time_s > 0


def test_a_flip_is_counted_and_then_repaired_by_the_neighbour():
    broken = plan_motion(ROBOT, Elbow(flip_from=20), START, TARGET)
    assert broken.flips == 1
    assert broken.largest_step > 1.0
    mended = plan_motion(ROBOT, Elbow(flip_from=20), START, TARGET, repair=Elbow())
    assert mended.flips == 0
    assert mended.tip_error_mm.max() < 1e-9


class BlockedElbow(Elbow):
    """Keeps the branch of its seed, and loses the elbow-up branch half way."""

    def solve(self, poses, initial=None, budget=None):
        up = super().solve(poses)
        down = Mirror().solve(poses)
        prefers_down = np.broadcast_to(np.atleast_2d(initial)[:, 1] < 0, len(poses))
        joints = np.where(prefers_down[:, None], down.joints, up.joints)
        lost = ~prefers_down & (poses[:, 1] > 0.4)
        joints[lost] = down.joints[lost]
        return SimpleNamespace(joints=joints, found=up.found)


class Mirror(Elbow):
    """The other branch throughout."""

    def __init__(self):
        super().__init__(flip_from=0)


def test_another_branch_is_found_where_the_first_one_ends():
    assert plan_motion(ROBOT, BlockedElbow(), START, TARGET).flips == 1
    mended = plan_motion(ROBOT, BlockedElbow(), START, TARGET, repair=BlockedElbow())
    assert mended.flips == 0
    assert (mended.joints[:, 1] < 0).all()
    assert mended.tip_error_mm.max() < 1e-9


def test_a_branch_that_must_be_left_is_reported():
    start = Elbow().solve(START[None]).joints[0]
    motion = plan_motion(ROBOT, BlockedElbow(), start, TARGET, repair=BlockedElbow())
    assert motion.flips == 1


def test_a_wide_step_along_the_path_is_no_flip():
    joints = np.array([[0.0, 0.9], [0.9, 0.9]])
    middle = ROBOT.forward_kinematics(joints.mean(axis=0, keepdims=True))[0]
    poses = np.stack([middle, middle])
    assert not branch_flips(ROBOT, joints, poses).any()


def test_start_joints_are_the_first_waypoint():
    start = np.array([-0.4, 1.1])
    motion = plan_motion(ROBOT, Elbow(), start, TARGET)
    assert_allclose(motion.joints[0], start)
    assert_allclose(motion.poses[0], ROBOT.forward_kinematics(start)[0])


def test_target_joints_are_the_last_waypoint():
    target = np.array([0.9, 0.7])
    motion = plan_motion(ROBOT, Elbow(), START, target)
    assert_allclose(motion.joints[-1], target)
    assert_allclose(motion.poses[-1], ROBOT.forward_kinematics(target)[0])


def test_out_of_reach_is_reported_not_raised():
    far = np.array([3.0, 0.0, 0.0, *UP])
    motion = plan_motion(ROBOT, Elbow(), START, far)
    assert not motion.found[-1]
    assert motion.tip_error_mm[-1] > 1000


@pytest.mark.parametrize("bad", [np.zeros(3), np.full(7, np.nan), np.zeros(7), np.zeros((2, 7))])
def test_neither_pose_nor_joints_is_refused(bad):
    with pytest.raises(ValueError, match="start must be a pose"):
        plan_motion(ROBOT, Elbow(), bad, TARGET)


def test_approach_ends_vertically_and_clears_its_start():
    motion = MotionConfig("approach", 0.05, 1, 0.15, 3, 50)
    points = control_points(START, TARGET, motion)
    assert points.shape == (4, 3)
    path = tip_path(START, TARGET, points)[:, :3]
    low = path[:, 2] < 0.075
    sideways = np.linalg.norm(path[:, :2] - TARGET[:2], axis=1)
    last_leg = low & (np.arange(50) > 25)
    assert last_leg.sum() >= 5
    assert sideways[last_leg].max() < 0.01
    assert (path[:, 2] >= -1e-12).all()


def test_straight_rule_has_no_control_points():
    assert control_points(START, TARGET, MotionConfig("straight", 0.0, 0, 0.0, 0, 50)).shape == (
        0,
        3,
    )
