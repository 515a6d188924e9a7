"""`found` means within the tolerances, for every solver at every setting; errors by Pinocchio."""

from functools import cache
from pathlib import Path

import numpy as np
import pinocchio
import pytest

import baselines
from baselines import Budget, SkippedSolver, Solver
from baselines.registry import settings
from robots import Robot, load_robot
from tests.small_arms import LIMIT, arm, save

NAMES = tuple(name for name in baselines.names() if "weights" not in settings(name))
# Settings by the key that a solver has; those of others are left out.
LOOSE_AND_TIGHT: dict[str, dict[str, float]] = {
    "as set": {},
    "position loose": {"position_tolerance_m": 5e-2, "tolerance": 1e-4, "epsilon": 1e-2},
    "rotation loose": {"rotation_tolerance_rad": 0.2, "matrix_tolerance": 1e-2},
    "tight": {"position_tolerance_m": 1e-6, "rotation_tolerance_rad": 1e-6, "epsilon": 1e-6},
}
ROOM = 1.001  # of the tolerance, for rounding


@cache
def robot_named(name: str, folder: Path) -> Robot:
    if name == "panda":
        return load_robot("panda")
    text = arm(6, limit=LIMIT.replace('"-1"', '"-2"').replace('"1"', '"2"', 1))
    for joint, kind in (("j1", "prismatic"), ("j4", "continuous")):
        text = text.replace(f'name="{joint}" type="revolute"', f'name="{joint}" type="{kind}"')
    return load_robot(urdf=save(folder, text))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("arms")


def make(name: str, robot: Robot, wanted: dict[str, float]) -> Solver:
    known = settings(name)
    try:
        return baselines.load(name, robot, **{k: v for k, v in wanted.items() if k in known})
    except SkippedSolver as reason:
        pytest.skip(str(reason))


def errors(robot: Robot, joints: np.ndarray, poses: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance [m] and angle [rad] from tip to pose, as Pinocchio computes them."""
    model, frame = robot.pinocchio()
    data = model.createData()
    found = np.empty((len(joints), 2))
    for row, (q, pose) in enumerate(zip(joints, poses, strict=True)):
        pinocchio.framesForwardKinematics(model, data, q)
        w, x, y, z = pose[3:] / np.linalg.norm(pose[3:])
        goal = pinocchio.Quaternion(w, x, y, z).toRotationMatrix()
        found[row, 0] = np.linalg.norm(data.oMf[frame].translation - pose[:3])
        found[row, 1] = np.linalg.norm(pinocchio.log3(data.oMf[frame].rotation.T @ goal))
    return found[:, 0], found[:, 1]


@pytest.mark.parametrize("robot_name", ["panda", "mixed"])
@pytest.mark.parametrize("setting", LOOSE_AND_TIGHT)
@pytest.mark.parametrize("name", NAMES)
def test_what_is_called_found_is_within_the_tolerances(
    name: str, setting: str, robot_name: str, folder: Path
) -> None:
    robot = robot_named(robot_name, folder)
    solver = make(name, robot, LOOSE_AND_TIGHT[setting])
    assert all(0.0 < tolerance < 1.0 for tolerance in solver.tolerances)
    poses = robot.forward_kinematics(robot.sample(60, seed=2))
    budget = Budget(time_s=0.02) if "time_s" in solver.budgets else Budget(iterations=100)
    solution = solver.solve(poses, budget=budget)
    distance, angle = errors(robot, solution.joints, poses)
    assert (distance[solution.found] <= ROOM * solver.tolerances[0] + 1e-9).all()
    assert (angle[solution.found] <= ROOM * solver.tolerances[1] + 1e-9).all()
    assert [reason == "" for reason in solution.reason] == solution.found.tolist()
    if setting != "tight":
        assert solution.found.any()


@pytest.mark.parametrize("robot_name", ["panda", "mixed"])
@pytest.mark.parametrize("name", NAMES)
def test_joints_are_within_the_limits_wherever_the_target_is(
    name: str, robot_name: str, folder: Path
) -> None:
    robot = robot_named(robot_name, folder)
    solver = make(name, robot, {})
    positions = [[1e3, 0, 0], [1e154, 0, 0], [-1e200, 1, 1], [1e308, 1e308, -1e308], [0, 0, 0]]
    turns = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, -0.6, 0.8], [-0.0, 0, 0, -1], [0, 0, 1, 0]]
    poses = np.hstack([positions, turns])
    budget = Budget(time_s=0.01) if "time_s" in solver.budgets else Budget(iterations=50)
    solution = solver.solve(poses, budget=budget)
    assert ((solution.joints >= robot.lower) & (solution.joints <= robot.upper)).all()
    assert not solution.found[:4].any()
