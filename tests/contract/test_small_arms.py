"""Arms of one to five joints: every solver solves them or says beforehand that it cannot."""

from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import Budget
from baselines.registry import settings
from robots import load_robot
from tests.small_arms import arm, save

NAMES = tuple(name for name in baselines.names() if "weights" not in settings(name))
WIDE = '<limit lower="-1e7" upper="1e7" velocity="1" effort="1"/>'
LIMITS = {
    "narrow": '<limit lower="-2" upper="2" velocity="1" effort="1"/>',
    "wide": '<limit lower="-400" upper="400" velocity="1" effort="1"/>',
    "none": WIDE,
}


@pytest.mark.parametrize("limit", LIMITS)
@pytest.mark.parametrize("count", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("name", NAMES)
def test_an_arm_of_few_joints_is_solved(name: str, count: int, limit: str, tmp_path: Path) -> None:
    robot = load_robot(urdf=save(tmp_path, arm(count, limit=LIMITS[limit])))
    if reason := baselines.skip(name, robot):
        assert "only" in reason or "not installed" in reason
        return
    solver = baselines.load(name, robot)
    poses = robot.forward_kinematics(robot.sample(8, seed=3))
    budget = Budget(time_s=0.3) if "time_s" in solver.budgets else None
    solution = solver.solve(poses, budget=budget)
    assert robot.within_limits(solution.joints).all()
    if name != "placo_once":  # one descent alone finds little where a joint has many turns
        assert solution.found.mean() > 0.7
    unreachable = poses + np.array([3.0, 0, 0, 0, 0, 0, 0])
    short = Budget(time_s=0.01) if "time_s" in solver.budgets else Budget(iterations=25)
    assert not solver.solve(unreachable, budget=short).found.any()


@pytest.mark.parametrize("name", NAMES)
def test_a_rail_of_ten_kilometres(name: str, tmp_path: Path) -> None:
    text = arm(4, limit=LIMITS["narrow"]).replace(
        'name="j1" type="revolute"', 'name="j1" type="prismatic"'
    )
    text = text.replace('lower="-2" upper="2"', 'lower="-1e4" upper="1e4"', 1)
    robot = load_robot(urdf=save(tmp_path, text))
    if reason := baselines.skip(name, robot):
        pytest.skip(reason)
    solver = baselines.load(name, robot)
    poses = robot.forward_kinematics(robot.sample(4, seed=1))
    budget = Budget(time_s=0.3) if "time_s" in solver.budgets else Budget(iterations=600)
    solution = solver.solve(poses, budget=budget)
    assert robot.within_limits(solution.joints).all()
