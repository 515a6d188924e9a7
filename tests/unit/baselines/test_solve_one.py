"""`solve_one` answers what `solve` answers to a batch of one, whatever path it takes."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import Budget, InitialError, PoseError, Solver
from baselines.compiled_query import FEW
from pipeline import load_solver
from robots import Robot, load_robot

ROBOTS = ("panda", "fetch", "nico")
COMPILED = ("lm", "cycleik_refined")
OTHERS = ("cycleik", "bio_ik", "pinocchio")


@pytest.fixture(scope="module", params=[(r, s) for r in ROBOTS for s in COMPILED], ids="-".join)
def solver(request: pytest.FixtureRequest) -> Solver:
    robot, name = request.param
    return load_solver(name, load_robot(robot))


def drawn(robot: Robot, count: int, seed: int = 3) -> np.ndarray:
    return robot.forward_kinematics(robot.sample(count, seed=seed, collision_free=False))


def test_it_equals_the_batch_bit_for_bit(solver: Solver) -> None:
    poses = drawn(solver.robot, 200)
    batch = solver.solve(poses)
    for row, pose in enumerate(poses):
        joints, found = solver.solve_one(pose)
        alone = solver.solve(pose[None])
        np.testing.assert_array_equal(joints, batch.joints[row])
        np.testing.assert_array_equal(alone.joints[0], batch.joints[row])
        assert found == alone.found[0] == batch.found[row]
        assert alone.iterations[0] == batch.iterations[row]
        assert alone.reason[0] == batch.reason[row]
        assert alone.time_s[0] > 0


@pytest.mark.parametrize("scale", [0.5, 8.0, 1e7])
def test_an_initial_guess_is_treated_as_in_a_batch(solver: Solver, scale: float) -> None:
    """Guesses outside the limits, by full turns and beyond `FARTHEST` too."""
    poses = drawn(solver.robot, 40)
    guesses = np.random.default_rng(1).normal(scale=scale, size=(40, solver.robot.dof))
    batch = solver.solve(poses, guesses)
    for pose, guess, row in zip(poses, guesses, batch.joints, strict=True):
        np.testing.assert_array_equal(solver.solve_one(pose, guess)[0], row)
        np.testing.assert_array_equal(solver.solve(pose[None], guess[None]).joints[0], row)
        np.testing.assert_array_equal(solver.solve(pose[None], guess).joints[0], row)
    shared = solver.solve(poses, guesses[0]).joints
    for few in (2, FEW, FEW + 1):
        own = solver.solve(poses[:few], guesses[:few]).joints
        np.testing.assert_array_equal(own, batch.joints[:few])
        np.testing.assert_array_equal(solver.solve(poses[:few], guesses[0]).joints, shared[:few])


@pytest.mark.parametrize("few", [2, FEW])
def test_a_few_poses_are_rows_of_the_batch(solver: Solver, few: int) -> None:
    poses = drawn(solver.robot, 40)
    poses[few] = poses[few] + np.array([9.0, 0, 0, 0, 0, 0, 0])  # out of reach
    batch = solver.solve(poses, budget=Budget(iterations=60))
    for first in range(0, 2 * few, few - 1):
        rows = slice(first, first + few)
        alone = solver.solve(poses[rows], budget=Budget(iterations=60))
        np.testing.assert_array_equal(alone.joints, batch.joints[rows])
        np.testing.assert_array_equal(alone.found, batch.found[rows])
        np.testing.assert_array_equal(alone.iterations, batch.iterations[rows])
        assert alone.reason == batch.reason[rows]
    with pytest.raises(InitialError, match=rf"\({few}, {solver.robot.dof}\)"):
        solver.solve(poses[:few], np.zeros((few + 1, solver.robot.dof)))


def test_numbers_of_other_types_and_layouts_are_taken(solver: Solver) -> None:
    pose = drawn(solver.robot, 1)[0]
    expected = solver.solve(pose[None]).joints[0]
    frozen = pose.copy()
    frozen.flags.writeable = False
    spread = np.repeat(pose, 2)[::2]
    for given in (pose.tolist(), tuple(pose), frozen, spread, pose.astype(">f8")):
        np.testing.assert_array_equal(solver.solve_one(given)[0], expected)
    rounded = pose.astype(np.float32)
    single = solver.solve(rounded[None].astype(np.float64)).joints[0]
    np.testing.assert_array_equal(solver.solve_one(rounded)[0], single)


def test_what_the_batch_draws_in_or_refuses_is_treated_so(solver: Solver) -> None:
    pose = drawn(solver.robot, 1)[0]
    far = pose.copy()
    far[0] = 1e200
    joints, found = solver.solve_one(far)
    assert not found
    np.testing.assert_array_equal(joints, solver.solve(far[None]).joints[0])
    for entry, value in ((0, np.nan), (2, np.inf), (4, 3.0), (6, np.nan)):
        wrong = pose.copy()
        wrong[entry] = value
        with pytest.raises(PoseError):
            solver.solve_one(wrong)
    for shape in (pose[:6], pose[None], np.zeros((0, 7)), "pose", None):
        with pytest.raises(PoseError):
            solver.solve_one(shape)
    home = solver.robot.home
    for guess in (
        home[:-1],
        home[None],
        np.full_like(home, np.nan),
        np.full_like(home, np.inf),
        ["a"] * len(home),
    ):
        with pytest.raises(InitialError):
            solver.solve_one(pose, guess)


def test_its_own_budget_holds_and_may_be_replaced() -> None:
    solver = load_solver("lm", load_robot("panda"), iterations=1, nearest_starts=0)
    poses = drawn(solver.robot, 50)
    assert not any(solver.solve_one(pose)[1] for pose in poses)
    assert solver.solve(poses[:1]).reason == ("out of iterations",)
    solver.budget = Budget(iterations=5000)
    assert all(solver.solve_one(pose)[1] for pose in poses)
    solver.budget = Budget(time_s=1e-9)
    assert solver.solve(poses[:1] + 10 * np.eye(7)[0]).reason == ("out of time",)


@pytest.mark.parametrize("budget", [Budget(iterations=8), Budget(time_s=0.5)], ids=str)
def test_a_batch_of_one_under_a_budget_is_a_row_of_the_batch(
    solver: Solver, budget: Budget
) -> None:
    poses = drawn(solver.robot, 30)
    whole = solver.solve(poses, budget=budget)
    for row, pose in enumerate(poses):
        one = solver.solve(pose[None], budget=budget)
        np.testing.assert_array_equal(one.joints[0], whole.joints[row])
        assert one.found[0] == whole.found[row]
        assert one.reason == whole.reason[row : row + 1]
        assert one.iterations[0] == whole.iterations[row]


def test_copies_and_pickles_answer_alike(solver: Solver) -> None:
    pose = drawn(solver.robot, 1)[0]
    expected = solver.solve_one(pose)[0]
    for other in (copy.deepcopy(solver), pickle.loads(pickle.dumps(solver))):
        np.testing.assert_array_equal(other.solve_one(pose)[0], expected)


def test_an_answer_is_the_callers_own(solver: Solver) -> None:
    first, second = drawn(solver.robot, 2)
    kept = solver.solve_one(first)[0]
    before = kept.copy()
    solver.solve_one(second)
    np.testing.assert_array_equal(kept, before)


@pytest.mark.parametrize("name", OTHERS)
def test_solvers_without_a_compiled_query_have_it_too(name: str) -> None:
    solver = load_solver(
        name, load_robot("panda"), **({"time_s": 0.05} if name != "cycleik" else {})
    )
    pose = drawn(solver.robot, 1)[0]
    joints, found = solver.solve_one(pose, solver.robot.home)
    batch = solver.solve(pose[None], solver.robot.home)
    assert joints.shape == (7,) and isinstance(found, bool)
    if name == "cycleik":
        np.testing.assert_array_equal(joints, batch.joints[0])
    else:
        reached = solver.robot.forward_kinematics(joints[None])[0]
        assert not found or np.linalg.norm(reached[:3] - pose[:3]) < 2e-3
    with pytest.raises(PoseError):
        solver.solve_one(pose[None])


def test_a_coupled_joint_and_a_robot_of_one_joint(tmp_path: Path) -> None:
    urdf = tmp_path / "arm.urdf"
    urdf.write_text(
        """<robot name="arm"><link name="base"/><link name="a"/><link name="b"/>
        <joint name="first" type="revolute"><parent link="base"/><child link="a"/>
          <axis xyz="0 0 1"/><limit lower="-2" upper="2" velocity="1" effort="1"/></joint>
        <joint name="second" type="revolute"><parent link="a"/><child link="b"/>
          <origin xyz="0.3 0 0.1"/><axis xyz="0 1 0"/>
          <limit lower="-2" upper="2" velocity="1" effort="1"/>
          <mimic joint="first" multiplier="0.5"/></joint></robot>"""
    )
    robot = load_robot(urdf=urdf, base="base", tip="b")
    solver = baselines.load("lm", robot)
    poses = robot.forward_kinematics(np.linspace(-1.9, 1.9, 9)[:, None])
    for pose in poses:
        joints, found = solver.solve_one(pose)
        assert found
        np.testing.assert_array_equal(joints, solver.solve(pose[None]).joints[0])


def test_outside_its_box_the_network_proposes_nothing() -> None:
    """NICOL's network learned poses of a box that holds a quarter of its reach."""
    solver = load_solver("cycleik_refined", load_robot("nicol"))
    poses = drawn(solver.robot, 300)
    centre = solver.proposer.network.position_centre.numpy()
    half = solver.proposer.network.position_scale.numpy()
    inside = (np.abs(poses[:, :3] - centre) <= half).all(axis=1)
    assert 0.1 < inside.mean() < 0.9
    np.testing.assert_array_equal(solver.proposer.in_domain(poses), inside)
    proposed = solver.proposer.hypotheses(poses).joints[:, :2]
    seeds = np.full((300, 2, solver.robot.dof), np.nan)
    for rows in (slice(0, 100), slice(100, 300)):
        solver.proposer.seeding(poses, seeds)(rows)
    wanted = np.where(inside[:, None, None], proposed, solver.robot.home)
    np.testing.assert_array_equal(seeds, wanted)
    batch = solver.solve(poses)
    assert batch.found.all()
    reached = solver.robot.forward_kinematics(batch.joints)
    assert np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).max() < 1.01e-4
    # Rows are where they were, whatever is solved with them.
    for rows in (inside, ~inside):
        np.testing.assert_array_equal(solver.solve(poses[rows]).joints, batch.joints[rows])


@pytest.mark.parametrize("name", ROBOTS)
def test_with_a_largest_jump_answers_stay_near_the_guess(name: str) -> None:
    robot = load_robot(name)
    solver = load_solver("lm", robot, max_jump=0.2)
    rng = np.random.default_rng(0)
    joints = robot.sample(200, seed=5, collision_free=False)
    moved = joints + rng.uniform(-0.1, 0.1, joints.shape)
    poses = robot.forward_kinematics(np.clip(moved, robot.lower, robot.upper))
    near = solver.solve(poses, joints)
    assert near.found.mean() > 0.97
    assert (near.iterations < 100).all()
    steps = np.abs(near.joints - joints)
    assert steps.max() <= 0.2 + 1e-12
    reached = robot.forward_kinematics(near.joints[near.found])
    assert np.linalg.norm(reached[:, :3] - poses[near.found, :3], axis=1).max() < 1.01e-4
    # A pose that only a long way leads to is not found, and nothing jumps for it.
    far = solver.solve(robot.forward_kinematics(joints[::-1].copy()), joints)
    assert far.found.mean() < 0.1
    assert np.abs(far.joints - joints).max() <= 0.2 + 1e-12
    single = [solver.solve_one(pose, guess) for pose, guess in zip(poses, joints, strict=True)]
    np.testing.assert_array_equal(np.array([row for row, _ in single]), near.joints)


@pytest.mark.parametrize("value", [0.0, -1.0, np.nan, "far"])
def test_a_largest_jump_is_a_number_above_zero(value: object) -> None:
    with pytest.raises(baselines.SettingError, match="max_jump"):
        baselines.load("lm", load_robot("panda"), max_jump=value)
