from pathlib import Path

import numpy as np
import pinocchio
import pytest

import baselines
from baselines import Budget, SkippedSolver, SolverError
from baselines.analytical import AnalyticalSolver
from baselines.chain_urdf import chain_urdf, chain_urdf_file
from robots import load_robot
from robots.serial_urdf import TIP

MIXED = Path(__file__).parents[2] / "fixtures" / "mixed.urdf"


@pytest.fixture(scope="module")
def panda():
    return load_robot("panda")


@pytest.fixture(scope="module")
def poses(panda):
    return panda.forward_kinematics(panda.sample(60, seed=8, collision_free=False))


@pytest.fixture(scope="module")
def mixed():
    """A chain with a sliding joint, and one that mimics another."""
    return load_robot(urdf=MIXED, base="bench", tip="tool")


def success(robot, joints, poses):
    """Share within 1 mm."""
    reached = robot.forward_kinematics(joints)
    return (np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1) < 1e-3).mean()


def test_the_bare_chain_has_the_kinematics_and_limits_of_the_robot(panda):
    model = pinocchio.buildModelFromXML(chain_urdf(panda))
    data, frame = model.createData(), model.getFrameId(TIP)
    assert np.allclose(model.lowerPositionLimit, panda.lower)
    assert np.allclose(model.upperPositionLimit, panda.upper)
    joints = panda.sample(20, seed=0, collision_free=False)
    for q, pose in zip(joints, panda.forward_kinematics(joints), strict=True):
        pinocchio.framesForwardKinematics(model, data, q)
        placement = data.oMf[frame]
        quaternion = pinocchio.Quaternion(placement.rotation).coeffs()[[3, 0, 1, 2]]
        assert np.allclose(placement.translation, pose[:3], atol=1e-12)
        assert abs(quaternion @ pose[3:]) == pytest.approx(1.0, abs=1e-12)


def test_the_file_of_the_bare_chain_is_removed(panda):
    with chain_urdf_file(panda) as path:
        assert path.exists()
    assert not path.exists()


@pytest.mark.parametrize("name", ["pinocchio", "placo"])
def test_restarts_solve_what_one_descent_does_not(panda, poses, name):
    budget = Budget(iterations=3000)
    with_restarts = baselines.load(name, panda).solve(poses, budget=budget)
    without = baselines.load(name, panda, restarts=False).solve(poses, budget=budget)
    assert success(panda, with_restarts.joints, poses) == 1.0
    assert success(panda, without.joints, poses) < 0.95
    assert "stalled" in without.reason


@pytest.mark.parametrize("name", ["pinocchio", "placo", "bio_ik"])
def test_a_row_does_not_depend_on_its_batch(panda, poses, name):
    solver = baselines.load(name, panda)
    whole = solver.solve(poses[:8], budget=Budget(iterations=60))
    alone = solver.solve(poses[7:8], budget=Budget(iterations=60))
    assert np.array_equal(whole.joints[7], alone.joints[0])


@pytest.mark.parametrize("name", ["pinocchio", "placo", "bio_ik", "pytorch_kinematics"])
def test_a_guess_at_the_solution_is_kept(panda, name):
    joints = panda.sample(4, seed=4, collision_free=False)
    solution = baselines.load(name, panda).solve(panda.forward_kinematics(joints), initial=joints)
    assert solution.found.all()
    assert np.allclose(solution.joints, joints, atol=1e-6)


def test_bio_ik_converges_without_a_clock(panda, poses):
    solution = baselines.load("bio_ik", panda).solve(poses, budget=Budget(iterations=250))
    assert success(panda, solution.joints, poses) > 0.9


def test_pytorch_kinematics_solves_batches_of_any_size(panda, poses):
    whole = baselines.load("pytorch_kinematics", panda).solve(poses)
    parts = baselines.load("pytorch_kinematics", panda, batch=25).solve(poses)
    assert whole.found.mean() > 0.9
    assert np.array_equal(whole.found, parts.found)


def test_trac_ik_refuses_limits_that_it_misread(panda, monkeypatch):
    pytracik = pytest.importorskip("pytracik")
    monkeypatch.setattr(pytracik, "get_joint_lower_bounds", lambda solver: [0.0] * 7)
    with pytest.raises(SolverError, match="read the limits of panda"):
        baselines.load("trac_ik", panda)


def test_trac_ik_keeps_a_solver_for_each_budget(panda, poses):
    pytest.importorskip("pytracik")
    solver = baselines.load("trac_ik", panda)
    solver.solve(poses[:1], budget=Budget(time_s=0.02))
    solution = solver.solve(poses)
    assert sorted(solver._solvers) == [0.02, solver.budget.time_s]
    assert success(panda, solution.joints, poses) > 0.95


@pytest.mark.parametrize("name", ["lm", "bio_ik"])
def test_our_own_solvers_know_sliding_and_coupled_joints(mixed, name):
    joints = mixed.sample(20, seed=1, collision_free=False)
    targets = mixed.forward_kinematics(joints)
    # Three variables do not reach a pose but by the same joints: start near, follow the motion.
    near = np.clip(joints + 0.02, mixed.lower, mixed.upper)
    budget = Budget(iterations=500)  # no clock: the machine may be busy
    solution = baselines.load(name, mixed).solve(targets, initial=near, budget=budget)
    assert solution.found.all()
    assert success(mixed, solution.joints, targets) == 1.0


@pytest.mark.parametrize("name", ["pinocchio", "placo", "pytorch_kinematics", "trac_ik"])
def test_coupled_joints_are_a_reason_to_skip(mixed, name):
    with pytest.raises(SkippedSolver, match="mimics"):
        baselines.load(name, mixed)


def test_solvers_of_the_panda_skip_others(panda):
    nico = load_robot("nico")
    for name in ("frankik", "ssik"):
        pytest.importorskip(name)
        assert baselines.skip(name, panda) is None
        assert "nico is another robot" in baselines.skip(name, nico)


def test_optik_skips_sliding_joints():
    pytest.importorskip("optik")
    assert "sliding" in baselines.skip("optik", load_robot("fetch"))


class Proposing(AnalyticalSolver):
    """Proposes what a test sets."""

    def _candidates(self, end, guess):
        yield self.proposals.copy()


def lm_other(robot, pose, joints):
    """Joints that reach a pose (1, 7) and are not `joints`."""
    solver = baselines.load("lm", robot)
    for seed in range(20):
        found = solver.solve(pose, robot.sample(1, seed=seed, collision_free=False)[0])
        if found.found[0] and np.abs(found.joints[0] - joints).max() > 0.5:
            # To the tolerance of an analytical solver.
            exact = baselines.load(
                "lm", robot, position_tolerance_m=1e-9, rotation_tolerance_rad=1e-9
            ).solve(pose, found.joints[0])
            return exact.joints[0]
    raise AssertionError("no other solution was found")


def test_analytical_proposals_are_checked(panda):
    solver = Proposing(panda, limit_tolerance=1e-6, matrix_tolerance=1e-4, tool=np.eye(4))
    joints = panda.sample(3, seed=6, collision_free=False)
    pose = panda.forward_kinematics(joints[:1])
    solver.proposals = np.empty((0, 7))
    assert solver.solve(pose).reason == ("no solution",)
    # Wrong branch, not a number, outside the limits.
    solver.proposals = np.array([joints[1], np.full(7, np.nan), panda.upper + 0.1])
    assert not solver.solve(pose).found[0]
    # A hair outside counts as inside; the right one is taken.
    solver.proposals = np.array([joints[1], joints[0]])
    solution = solver.solve(pose)
    assert solution.found[0] and np.array_equal(solution.joints[0], joints[0])
    edge = panda.forward_kinematics(panda.upper[None])
    solver.proposals = panda.upper[None] + 1e-7
    solution = solver.solve(edge)
    assert solution.found[0] and np.array_equal(solution.joints[0], panda.upper)
    # Of two that are right the one nearer to the initial guess is taken, also by a single query.
    near, far = joints[0], lm_other(panda, pose, joints[0])
    for first, second in ((near, far), (far, near)):
        solver.proposals = np.array([far, near])
        np.testing.assert_array_equal(solver.solve(pose, first).joints[0], first)
        np.testing.assert_array_equal(solver.solve_one(pose[0], first)[0], first)
        assert not np.array_equal(first, second)
    assert solver.solve_one(edge[0])[1] is False


SIX = """<robot name="six"><link name="l0"/>{joints}</robot>"""
JOINT = """<link name="l{k}"/><joint name="j{k}" type="revolute"><parent link="l{before}"/>
<child link="l{k}"/><origin xyz="{xyz}" rpy="0 0 0"/><axis xyz="{axis}"/>
<limit lower="{low}" upper="{high}" velocity="2" effort="9"/></joint>"""


def six_joints(folder, low=-3.1, high=3.1):
    """A shoulder, three parallel axes and a wrist, as a UR has them."""
    places = ("0 0 .1", "0 .1 0", "0 0 .4", "0 0 .4", "0 .1 0", "0 0 .1")
    axes = ("0 0 1", "0 1 0", "0 1 0", "0 1 0", "0 0 1", "0 1 0")
    joints = "".join(
        JOINT.format(k=k + 1, before=k, xyz=xyz, axis=axis, low=low, high=high)
        for k, (xyz, axis) in enumerate(zip(places, axes, strict=True))
    )
    path = folder / "six.urdf"
    path.write_text(SIX.format(joints=joints), encoding="utf-8")
    return load_robot(urdf=path)


def test_eaik_has_all_solutions_of_a_six_joint_arm(tmp_path):
    pytest.importorskip("eaik")
    robot = six_joints(tmp_path)
    poses = robot.forward_kinematics(robot.sample(50, seed=1, collision_free=False))
    solver = baselines.load("eaik", robot)
    solution = solver.solve(poses)
    assert solution.found.all()
    assert success(robot, solution.joints, poses) == 1.0
    found = solver.solve_all(poses[0], 8, apart=0.05)
    known = baselines.load("lm", robot).solve_all(poses[0], 20, apart=0.05)
    assert len(found) >= len(known) >= 2  # `lm` searches, and may miss one
    far = poses[:5] + np.array([2.0, 0, 0, 0, 0, 0, 0])
    assert not solver.solve(far).found.any()


def test_eaik_takes_whole_turns_towards_the_guess(tmp_path):
    pytest.importorskip("eaik")
    robot = six_joints(tmp_path, low=-6.2, high=6.2)
    joints = np.array([[4.0, -4.5, 1.0, 5.0, 1.2, -5.5]])
    solution = baselines.load("eaik", robot).solve(robot.forward_kinematics(joints), joints + 0.01)
    assert solution.found[0]
    assert np.allclose(solution.joints, joints, atol=1e-6)


def test_eaik_skips_what_it_cannot_take_apart(panda):
    pytest.importorskip("eaik")
    assert "6 revolute joints" in baselines.skip("eaik", panda)
    assert "knows no decomposition of nico" in baselines.skip("eaik", load_robot("nico"))
