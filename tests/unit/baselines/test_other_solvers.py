from pathlib import Path

import numpy as np
import pinocchio
import pytest

import baselines
from baselines import Budget, SolverError
from baselines.chain_urdf import chain_urdf, chain_urdf_file
from robots import load_robot

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


@pytest.fixture(scope="module")
def panda():
    return load_robot("panda")


@pytest.fixture(scope="module")
def poses(panda):
    return panda.forward_kinematics(panda.sample(60, seed=8, collision_free=False))


def success(robot, joints, poses):
    """Share within 1 mm."""
    reached = robot.forward_kinematics(joints)
    return (np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1) < 1e-3).mean()


def test_the_bare_chain_has_the_kinematics_and_limits_of_the_robot(panda):
    model = pinocchio.buildModelFromXML(chain_urdf(panda))
    data, frame = model.createData(), model.getFrameId(panda.tip)
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
