"""Refined networks: many solutions, poses in part and reasons, from their hypotheses on."""

from __future__ import annotations

import numpy as np
import pytest

from baselines import Freedom, Solver
from baselines.checks import check_poses
from pipeline import load_robot, load_solver
from pipeline.learning.refined import RefinedSolver
from pipeline.learning.solver import Hypotheses


@pytest.fixture(scope="module")
def solver() -> Solver:
    return load_solver("cycleik_refined", load_robot("panda"))


def test_the_network_seeds_all_that_can_be_asked(solver: Solver) -> None:
    robot = solver.robot
    poses = robot.forward_kinematics(robot.sample(20, seed=5))
    found = solver.solve_all(poses[0], 5, apart=0.2, initial=robot.home)
    assert len(found) == 5
    assert np.abs(robot.forward_kinematics(found) - poses[0])[:, :3].max() < 1.1e-4
    placed = solver.solve_partial(poses, Freedom.position_only())
    assert placed.found.all()
    reached = robot.forward_kinematics(placed.joints)
    assert np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).max() < 1.1e-4
    assert solver.explain(poses[0]).reason == "reachable"
    far = poses[0] + np.array([0, 0, 3.0, 0, 0, 0, 0])
    assert solver.explain(far).reason == "out of reach"


def test_a_network_alone_answers_whole_poses(solver: Solver) -> None:
    alone = load_solver("cycleik", solver.robot)
    assert alone.lacks("solve_partial") == "solver 'cycleik' has no solve_partial"


def counted(solver: Solver, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """How many poses the network is asked about, call by call."""
    assert isinstance(solver, RefinedSolver)
    asked: list[int] = []
    hypotheses = solver.proposer.hypotheses

    def counting(poses: np.ndarray) -> Hypotheses:
        asked.append(len(poses))
        return hypotheses(poses)

    monkeypatch.setattr(solver.proposer, "hypotheses", counting)
    return asked


def test_a_guess_that_leads_to_a_solution_spares_the_network(
    solver: Solver, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 40 guesses half are near; the others are descended from, and then the hypotheses."""
    robot, draw = solver.robot, np.random.default_rng(0)
    joints = robot.sample(40, seed=6)
    poses = robot.forward_kinematics(joints)
    near = np.clip(joints + draw.normal(0.0, 0.02, joints.shape), robot.lower, robot.upper)
    guesses = np.concatenate((near[:20], robot.sample(20, seed=7)))
    asked = counted(solver, monkeypatch)
    mixed = solver.solve(poses, guesses)
    assert mixed.found.all()
    assert len(asked) == 1
    assert 0 < asked[0] < 20
    assert solver.solve(poses[:20], near[:20]).found.all()
    assert len(asked) == 1
    assert isinstance(solver, RefinedSolver)
    targets = check_poses(poses)
    whole, spared = (
        f(targets, guesses[:, None], None) for f in (solver._answered, solver._proposed)
    )
    for name in ("joints", "status", "iterations", "starts"):
        assert np.array_equal(getattr(whole, name), getattr(spared, name)), name
    monkeypatch.undo()
    ones = [solver.solve_one(pose, guess)[0] for pose, guess in zip(poses, guesses, strict=True)]
    assert np.array_equal(mixed.joints, ones)
