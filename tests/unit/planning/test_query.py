"""How a batch is solved: networks by a path through their hypotheses, others by seeds."""

from __future__ import annotations

import itertools
from types import SimpleNamespace

import numpy as np
import pytest
from numpy.testing import assert_allclose

import baselines
from pipeline.planning.continuity import Ends, branch_flips, kernel_options
from pipeline.planning.motion import plan_motion
from pipeline.planning.query import Hypothesising, solve_waypoints
from pipeline.planning.search_kernel import cheapest_path, thinned
from robots import load_robot
from robots.rotations import rotation_angle

ROBOT = load_robot("panda")
WAY = ROBOT.home + np.linspace(0, 1, 50)[:, None] * [0.4, -0.3, 0.3, 0.3, -0.2, 0.4, 0.3]
POSES = ROBOT.forward_kinematics(WAY)


class TwoHeads:
    """A network whose better answer is now on the way, now far from it."""

    position_tolerance_mm, rotation_tolerance_deg = 10.0, 20.0

    def __init__(self, kernel=None):
        if kernel is not None:
            self.kernel = kernel
        self.requested = []

    def hypotheses(self, poses):
        self.requested.append(len(poses))
        generator = np.random.default_rng(1)
        near = WAY + generator.normal(0, 2e-3, WAY.shape)
        far = generator.uniform(ROBOT.lower, ROBOT.upper, WAY.shape)
        joints = np.stack([near, far], axis=1)
        joints[::3] = joints[::3, ::-1]
        reached = ROBOT.forward_kinematics(joints.reshape(-1, 7)).reshape(50, 2, 7)
        away = 1e3 * np.linalg.norm(reached[..., :3] - poses[:, None, :3], axis=2)
        turned = np.rad2deg(rotation_angle(reached[..., 3:], poses[:, None, 3:]))
        return SimpleNamespace(joints=joints, position_mm=away, rotation_deg=turned)


def test_of_a_network_the_way_with_least_travel_is_taken_in_one_query():
    network = TwoHeads()
    assert isinstance(network, Hypothesising)
    given = solve_waypoints(ROBOT, network, POSES, Ends(None, None))
    assert network.requested == [50]
    assert np.abs(given.joints - WAY).max() < 0.02
    assert given.found.all()
    assert given.candidates.shape == (50, 2, 7)


def test_a_refined_network_meets_the_tolerances_and_keeps_given_joints():
    lm = baselines.load("lm", ROBOT)
    motion = plan_motion(ROBOT, TwoHeads(lm), start_joints=WAY[0], target=POSES[-1])
    assert_allclose(motion.joints[0], WAY[0])
    assert motion.found.all()
    assert motion.flips == 0
    assert motion.tip_error_mm.max() < 0.2
    assert 0 < motion.query_s <= motion.time_s


def test_solvers_without_hypotheses_are_seeded_along_the_straight_way():
    calls = []

    class Seen:
        def solve(self, poses, initial=None):
            calls.append(np.array(initial))
            return SimpleNamespace(
                joints=WAY[[0, -1]] if len(poses) == 2 else WAY,
                found=np.ones(len(poses), dtype=bool),
            )

    given = solve_waypoints(ROBOT, Seen(), POSES, Ends(None, None))
    assert [call.shape for call in calls] == [(7,), (50, 7)]
    assert_allclose(calls[1], WAY, atol=1e-12)
    assert given.candidates is None


def test_only_solvers_with_the_compiled_kernel_can_mend():
    lm, placo = baselines.load("lm", ROBOT), baselines.load("placo", ROBOT)
    assert kernel_options(placo) is None
    assert kernel_options(TwoHeads(lm)) == kernel_options(lm)
    with pytest.raises(ValueError, match="repair must be lm or a refined solver"):
        plan_motion(ROBOT, lm, POSES[0], POSES[-1], repair=placo)


def test_a_solver_that_cannot_mend_its_own_answers_is_left_alone_or_mended_by_another():
    class Jumping:
        name = "jumping"

        def solve(self, poses, initial=None):
            joints = np.array(lm.solve(poses, initial=initial).joints)
            joints[2:][len(joints) // 2 - 2 :][:1] = ROBOT.lower  # not at the two ends
            return SimpleNamespace(joints=joints, found=np.ones(len(poses), dtype=bool))

    lm = baselines.load("lm", ROBOT)
    alone = plan_motion(ROBOT, Jumping(), POSES[0], POSES[-1])
    assert alone.flips == 2
    assert (alone.joints == alone.answers).all()
    mended = plan_motion(ROBOT, Jumping(), POSES[0], POSES[-1], repair=lm)
    assert mended.flips == 0
    assert branch_flips(ROBOT, mended.answers, mended.poses).sum() == 2


def test_the_cheapest_path_is_the_best_of_all():
    generator = np.random.default_rng(0)
    candidates, prices = generator.normal(size=(5, 3, 2)), generator.random((5, 3))
    chosen = np.zeros(5, dtype=np.int64)
    cheapest_path(candidates, prices, chosen)

    def cost(candidate):
        joints = candidates[np.arange(5), candidate]
        return (np.diff(joints, axis=0) ** 2).sum() + prices[np.arange(5), candidate].sum()

    best = min(itertools.product(range(3), repeat=5), key=lambda candidate: cost(list(candidate)))
    assert list(chosen) == list(best)


def test_thinning_keeps_the_best_of_those_that_are_near_and_fits():
    joints = np.random.default_rng(1).uniform(size=(500, 2))
    chosen, order = np.zeros(60, dtype=np.int64), np.arange(500)[::-1].copy()
    count = thinned(joints, order, 0.05, chosen)
    kept = joints[chosen[:count]]
    apart = np.abs(kept[:, None] - kept).max(axis=2) + np.eye(count)
    assert chosen[0] == 499
    assert 10 < count <= 60
    assert apart.min() >= 0.05
