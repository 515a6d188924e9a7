"""Refined networks: many solutions, poses in part and reasons, from their hypotheses on."""

from __future__ import annotations

import numpy as np
import pytest

from baselines import Freedom, Solver
from pipeline import load_robot, load_solver


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
