"""What every registered solver must do, on an arm that reaches a plane only and on real robots."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import Budget, BudgetError, InitialError, PoseError, SkippedSolver, Solver
from baselines.registry import FOLDER, settings
from robots import available_robots, load_robot

TWO_LINK = Path(__file__).parents[1] / "fixtures" / "two_link.urdf"
ROBOTS = ("two_link", *available_robots())
QUICK = ("two_link", "panda")
COUNT = 12
# Neural solvers need trained weights, which a fresh checkout may not have; `pipeline` tests them.
NAMES = tuple(name for name in baselines.names() if "weights" not in settings(name))


CASES = [
    pytest.param((name, robot), marks=[] if robot in QUICK else [pytest.mark.slow])
    for name in NAMES
    for robot in ROBOTS
]


@cache
def robot_named(name: str):
    if name == "two_link":
        return load_robot(urdf=TWO_LINK, base="base", tip="tip")
    return load_robot(name)


@pytest.fixture(scope="module", params=CASES, ids="-".join)
def solver(request) -> Solver:
    name, robot = request.param
    try:
        return baselines.load(name, robot_named(robot))
    except SkippedSolver as reason:
        pytest.skip(str(reason))


@pytest.fixture(scope="module")
def poses(solver):
    """Reachable poses, not far from home and off the limits, where local solvers do their best."""
    robot = solver.robot
    span = robot.upper - robot.lower
    share = np.random.default_rng(3).uniform(-0.3, 0.3, (COUNT, robot.dof))
    joints = np.clip(
        robot.home + share * span, robot.lower + 0.05 * span, robot.upper - 0.05 * span
    )
    return robot.forward_kinematics(joints)


def generous(solver: Solver) -> Budget | None:
    return Budget(time_s=0.2) if "time_s" in solver.budgets else solver.budget


def tip_errors(robot, joints, poses):
    """Distance [m] and angle [rad] between the tip and each pose."""
    reached = robot.forward_kinematics(joints)
    cosine = np.abs(np.sum(reached[:, 3:] * poses[:, 3:], axis=1))
    distance = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
    return distance, 2 * np.arccos(np.minimum(cosine, 1.0))


def assert_complete(solution, count, robot):
    assert solution.joints.shape == (count, robot.dof) and solution.joints.dtype == np.float64
    assert solution.found.shape == (count,) and solution.found.dtype == bool
    assert solution.time_s.shape == (count,) and (solution.time_s >= 0).all()
    assert solution.iterations.shape == (count,) and solution.iterations.dtype == np.int64
    assert len(solution.reason) == count
    assert [reason == "" for reason in solution.reason] == solution.found.tolist()
    assert np.isfinite(solution.joints).all()
    assert (solution.joints >= robot.lower).all() and (solution.joints <= robot.upper).all()


def test_reachable_poses_are_found_and_the_claim_is_true(solver, poses):
    solution = solver.solve(poses, budget=generous(solver))
    assert_complete(solution, COUNT, solver.robot)
    assert solution.found.mean() >= 0.75
    distance, angle = tip_errors(solver.robot, solution.joints, poses)
    assert (distance[solution.found] < 1e-3).all() and (angle[solution.found] < 0.0175).all()


def test_the_sign_of_the_quaternion_does_not_matter(solver, poses):
    turned = poses * np.array([1, 1, 1, -1, -1, -1, -1])
    solution = solver.solve(turned, budget=generous(solver))
    assert solution.found.mean() >= 0.75
    distance, _ = tip_errors(solver.robot, solution.joints, poses)
    assert (distance[solution.found] < 1e-3).all()


def test_unreachable_poses_are_not_found_and_the_budget_is_kept(solver, poses):
    far = poses.copy()
    far[:, 0] += 5.0
    limit = 0.01
    timed = "time_s" in solver.budgets
    budget = Budget(time_s=limit) if timed else Budget(iterations=20)
    solver.solve(far[:1], budget=budget)
    solution = solver.solve(far, budget=budget)
    assert_complete(solution, COUNT, solver.robot)
    assert not solution.found.any()
    if timed:
        # The least: others may be held up by a busy machine; benchmarks/solvers.py measures p99.
        assert solution.time_s.min() <= 1.2 * limit + 2e-4
    elif solver.budgets:
        assert (solution.iterations <= 20).all()


def test_an_iteration_budget_is_kept_and_gives_the_same_twice(solver, poses):
    if "iterations" not in solver.budgets:
        pytest.skip(f"{solver.name} heeds no iteration budget")
    first = solver.solve(poses, budget=Budget(iterations=15))
    again = solver.solve(poses, budget=Budget(iterations=15))
    assert_complete(first, COUNT, solver.robot)
    assert (first.iterations <= 15).all()
    assert np.array_equal(first.joints, again.joints)
    assert np.array_equal(first.iterations, again.iterations)


def test_an_initial_guess_may_be_given_for_all_or_each(solver, poses):
    robot, budget = solver.robot, generous(solver)
    one = solver.solve(poses[:2], initial=robot.home, budget=budget)
    each = solver.solve(poses[:2], initial=np.tile(robot.home, (2, 1)), budget=budget)
    assert_complete(one, 2, robot)
    assert_complete(each, 2, robot)
    with pytest.raises(InitialError, match="shape"):
        solver.solve(poses, initial=np.zeros(robot.dof + 1))
    with pytest.raises(InitialError, match="finite"):
        solver.solve(poses, initial=np.full(robot.dof, np.nan))


def test_an_empty_batch_gives_an_empty_result(solver):
    assert_complete(solver.solve(np.empty((0, 7))), 0, solver.robot)
    assert_complete(solver.solve([]), 0, solver.robot)


def test_bad_poses_are_refused_by_name(solver, poses):
    for value, message in ((np.nan, "pose 3 .*finite"), (np.inf, "pose 3 .*finite")):
        bad = poses.copy()
        bad[3, 1] = value
        with pytest.raises(PoseError, match=message):
            solver.solve(bad)
    bad = poses.copy()
    bad[2, 3:] *= 2
    with pytest.raises(PoseError, match=r"pose 2 has a quaternion .* norm 2"):
        solver.solve(bad)
    with pytest.raises(PoseError, match=r"\(N, 7\)"):
        solver.solve(poses[0])


def test_a_budget_of_another_kind_is_refused(solver, poses):
    kinds = {"time_s": 0.1, "iterations": 10}
    for kind, amount in kinds.items():
        if solver.budgets and kind not in solver.budgets:
            with pytest.raises(BudgetError, match=kind):
                solver.solve(poses, budget=Budget(**{kind: amount}))


@pytest.mark.parametrize("name", baselines.names())
def test_every_setting_is_explained_in_its_yaml(name):
    lines = (FOLDER / f"{name}.yaml").read_text().splitlines()
    assert lines[0].startswith("# ")
    for line in lines:
        if line and not line.startswith(("#", "_target_", "defaults", "  ")):
            assert " # " in line, f"{name}.yaml: no comment on {line!r}"
