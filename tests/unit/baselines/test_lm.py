from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import baselines
from baselines import Budget
from baselines.clock import now_ns, pose_key, uniform
from baselines.damped_solve import damped_solve
from baselines.linearise import find_error, find_jacobian, new_linearisation, set_target
from baselines.refine import refine
from robots import load_robot
from robots.rotations import matrix_from_quaternion, quaternion_multiply

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"
MIXED = TWO_LINK.with_name("mixed.urdf")


@pytest.fixture(scope="module")
def panda():
    return load_robot("panda")


@pytest.fixture(scope="module")
def two_link():
    return load_robot(urdf=TWO_LINK, base="base", tip="tip")


@pytest.fixture(scope="module")
def solver(panda):
    return baselines.load("lm", panda)


@pytest.fixture(scope="module")
def poses(panda):
    return panda.forward_kinematics(panda.sample(300, seed=5, collision_free=False))


def seeds_of(robot, count):
    return np.tile(robot.home, (count, 1, 1))


def linearised(robot, joints, pose):
    at = new_linearisation(len(robot.chain.prismatic), robot.dof)
    set_target(pose, at)
    squares = find_error(robot.chain, joints, pose, at)
    find_jacobian(robot.chain, at)
    return at, squares


@pytest.mark.parametrize("name", ["panda", "mixed"])
def test_the_linearisation_agrees_with_the_robot(panda, name):
    robot = panda if name == "panda" else load_robot(urdf=MIXED, base="bench", tip="tool")
    for joints in robot.sample(20, seed=2, collision_free=False):
        pose = robot.forward_kinematics(joints[None])[0]
        at, (distance2, angle2) = linearised(robot, joints, pose)
        assert np.allclose(at.position, pose[:3], atol=1e-14)
        assert np.allclose(at.rotation, matrix_from_quaternion(pose[3:]), atol=1e-14)
        assert np.allclose(at.jacobian.T, robot.jacobian(joints[None])[0], atol=1e-14)
        assert distance2 < 1e-24 and angle2 < 1e-20


def test_the_jacobian_predicts_the_error_of_a_small_step(panda):
    joints = panda.home
    rng = np.random.default_rng(1)
    for _ in range(20):
        step = rng.normal(size=7) * 1e-6
        pose = panda.forward_kinematics((joints + step)[None])[0]
        at, _ = linearised(panda, joints, pose)
        assert np.allclose(at.error, at.jacobian.T @ step, atol=1e-11)


@given(
    st.floats(0.0, np.pi),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 0.1),
)
def test_the_rotation_error_is_the_rotation_vector(two_link, angle, axis):
    axis = np.array(axis) / np.linalg.norm(axis)
    turn = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * axis])
    here = two_link.forward_kinematics(two_link.home[None])[0]
    pose = here.copy()
    pose[3:] = quaternion_multiply(turn, here[3:])
    at, (_, angle2) = linearised(two_link, two_link.home, pose)
    assert np.sqrt(angle2) == pytest.approx(angle, abs=1e-7)
    if 1e-6 < angle < np.pi - 1e-6:
        assert np.allclose(at.error[3:], angle * axis, atol=1e-7)


def test_half_a_turn_has_an_error_of_pi(two_link):
    here = two_link.forward_kinematics(np.zeros((1, 2)))[0]
    for axis in np.eye(3):
        pose = np.concatenate([here[:3], [0.0], axis])
        at, (_, angle2) = linearised(two_link, np.zeros(2), pose)
        assert np.sqrt(angle2) == pytest.approx(np.pi)
        assert np.linalg.norm(at.error[3:]) == pytest.approx(np.pi)


def test_the_damped_system_is_solved():
    rng = np.random.default_rng(0)
    for dof in (2, 6, 10):
        J, error = rng.normal(size=(dof, 6)), rng.normal(size=6)
        free = rng.uniform(size=dof) < 0.8
        y = np.empty(6)
        damped_solve(J, free, error, 1e-3, y)
        A = J[free].T @ J[free] + 1e-3 * np.eye(6)
        assert np.allclose(A @ y, error, atol=1e-9)


def test_every_pose_of_the_panda_is_solved(solver, panda, poses):
    solution = solver.solve(poses)
    assert solution.found.all()
    reached = panda.forward_kinematics(solution.joints)
    assert (np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1) <= 1.0001e-4).all()
    assert solution.iterations.mean() < 25


def test_two_links_are_solved_by_hand(two_link):
    """Upper arm along x, forearm along y: the tip is at (0.4, 0.3, 0.1)."""
    pose = np.array([[0.4, 0.3, 0.1, np.sqrt(0.5), 0, 0, np.sqrt(0.5)]])
    solution = baselines.load("lm", two_link, position_tolerance_m=1e-9).solve(pose)
    assert solution.found[0]
    assert np.allclose(solution.joints[0], [0.0, np.pi / 2], atol=1e-4)


def test_a_row_does_not_depend_on_batch_sign_or_threads(solver, panda, poses):
    whole = solver.solve(poses, budget=Budget(iterations=500))
    alone = solver.solve(poses[250:251] * [1, 1, 1, -1, -1, -1, -1], budget=Budget(iterations=500))
    assert np.allclose(alone.joints[0], whole.joints[250], atol=1e-9)
    threaded = baselines.load("lm", panda, threads=2).solve(poses, budget=Budget(iterations=500))
    assert np.array_equal(threaded.joints, whole.joints)
    assert np.array_equal(threaded.iterations, whole.iterations)


def test_a_seed_at_the_solution_needs_no_step(solver, panda):
    joints = panda.sample(5, seed=9, collision_free=False)
    solution = solver.solve(panda.forward_kinematics(joints), initial=joints)
    assert (solution.iterations == 0).all()
    assert np.array_equal(solution.joints, joints)


def test_seeds_are_tried_in_order(solver, panda, poses):
    joints = panda.sample(40, seed=9, collision_free=False)
    targets = panda.forward_kinematics(joints)
    hopeless = np.tile(panda.lower, (40, 1))
    options = solver.options(None)
    alone = refine(panda, targets, hopeless[:, None], options._replace(starts=1))
    stuck = ~alone.found
    assert stuck.sum() > 5
    both = refine(panda, targets, np.stack([hopeless, joints], axis=1), options)
    assert (both.starts[stuck] == 2).all()
    assert np.array_equal(both.joints[stuck], joints[stuck])


def test_starts_are_counted_and_limited(solver, panda, poses):
    options = solver.options(None)._replace(starts=1)
    refined = refine(panda, poses, seeds_of(panda, len(poses)), options)
    assert (refined.starts == 1).all()
    assert 0.5 < refined.found.mean() < 1.0
    assert set(refined.solution().reason) == {"", "out of starts"}


def test_no_seed_means_random_starts(solver, panda, poses):
    refined = refine(panda, poses, np.empty((len(poses), 0, 7)), solver.options(None))
    assert refined.found.all()


def test_a_search_without_end_ends_within_the_time(panda):
    far = np.array([[9.0, 0, 0, 1, 0, 0, 0]])
    solver = baselines.load("lm", panda, nearest_starts=0)
    solution = solver.solve(np.repeat(far, 9, axis=0), budget=Budget(time_s=0.003))
    assert set(solution.reason) == {"out of time"}
    kept = 0.003 * (1.0 - solver.settings["return_share"])
    assert (solution.time_s >= kept).all()
    assert kept < solution.time_s.min() < 0.003


def test_the_best_joints_of_an_unreachable_pose_point_at_it(two_link):
    """The nearest that two links of 0.7 m get to a point 2 m away along x is 1.3 m."""
    far = np.array([[2.0, 0, 0.1, 1, 0, 0, 0]])
    solver = baselines.load("lm", two_link, nearest_starts=0)
    solution = solver.solve(far, budget=Budget(iterations=300))
    assert not solution.found[0] and solution.iterations[0] == 300
    assert np.allclose(solution.joints[0], 0.0, atol=0.05)


def test_the_compiled_clock_runs_in_nanoseconds():
    import time

    timespec = np.empty(2, dtype=np.int64)
    before, between, after = time.monotonic_ns(), now_ns(timespec), time.monotonic_ns()
    assert before <= between <= after


def test_random_numbers_are_uniform_and_their_streams_differ():
    keys = [pose_key(np.array([x, 0, 0, 1.0, 0, 0, 0])) for x in (0.1, 0.2)]
    streams = np.array([[uniform(np.uint64(key), i) for i in range(4000)] for key in keys])
    assert streams.min() >= 0.0 and streams.max() < 1.0
    counts = np.histogram(streams[0], bins=10, range=(0, 1))[0]
    assert ((counts - 400) ** 2 / 400).sum() < 27.9  # chi squared, 9 degrees, 0.1 %
    assert abs(np.corrcoef(streams)[0, 1]) < 0.06
    assert abs(np.corrcoef(streams[0, 1:], streams[0, :-1])[0, 1]) < 0.06
