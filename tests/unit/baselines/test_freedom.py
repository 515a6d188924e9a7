"""Targets of which a part is free: what is allowed, what is found, judged by Pinocchio."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio
import pytest

import baselines
from baselines import AbilityError, Freedom, FreedomError
from baselines.freedom import FREE, nearest_allowed, widths_of
from baselines.freedom_kernel import free_error, free_rows, new_freedom_room
from baselines.linearise import find_error, find_jacobian, new_linearisation, set_target
from robots import Robot, load_robot
from robots.rotations import quaternion_from_rotation_vector, quaternion_multiply, rotation_angle
from tests.small_arms import arm, save

FREEDOMS = {
    "whole": Freedom(),
    "position": Freedom.position_only(),
    "axis x": Freedom.free_about("x"),
    "axis z": Freedom.free_about("z"),
    "box": Freedom((0.02, 0.0, FREE), (0.1, 0.3, 0.0)),
    "cone": Freedom((0.0, 0.01, 0.0), (0.2, 0.2, FREE)),
}
ROOM = 1.001


@pytest.fixture(scope="module", params=["panda", "mixed"])
def robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    if request.param == "panda":
        return load_robot("panda")
    text = arm(6, limit='<limit lower="-2" upper="2" velocity="1" effort="1"/>')
    for joint, kind in (("j1", "prismatic"), ("j4", "continuous")):
        text = text.replace(f'name="{joint}" type="revolute"', f'name="{joint}" type="{kind}"')
    return load_robot(urdf=save(tmp_path_factory.mktemp("arms"), text))


@cache
def model_of(robot: Robot) -> tuple[Any, Any, int]:
    model, frame = robot.pinocchio()
    return model, model.createData(), frame


def residuals(
    robot: Robot, q: np.ndarray, pose: np.ndarray, freedom: Freedom
) -> tuple[float, float]:
    """What counts of the error [m], [rad], by Pinocchio and from the definition alone."""
    model, data, frame = model_of(robot)
    pinocchio.framesForwardKinematics(model, data, q)
    w, x, y, z = pose[3:]
    goal = pinocchio.Quaternion(w, x, y, z).toRotationMatrix()
    tip = data.oMf[frame]
    along = goal.T @ (tip.translation - pose[:3])
    about = pinocchio.log3(goal.T @ tip.rotation)
    free = np.isinf(freedom.about_rad)
    if free.all():
        about = np.zeros(3)
    elif free.any():
        k = int(np.argmax(free))
        axis, reached = np.eye(3)[k], (goal.T @ tip.rotation)[:, k]
        across = np.cross(axis, reached)
        sine = np.linalg.norm(across)
        about = across / max(sine, 1e-300) * np.arctan2(sine, axis @ reached)
    widths = freedom.widths
    rest = np.concatenate([along, about])
    rest = rest - np.clip(rest, -widths, widths)
    return float(np.linalg.norm(rest[:3])), float(np.linalg.norm(rest[3:]))


@pytest.mark.parametrize("name", FREEDOMS)
def test_what_is_found_is_allowed_and_almost_all_is_found(robot: Robot, name: str) -> None:
    solver, freedom = baselines.load("lm", robot), FREEDOMS[name]
    poses = robot.forward_kinematics(robot.sample(40, seed=3, collision_free=False))
    solution = solver.solve_partial(poses, freedom)
    assert solution.found.mean() > 0.95
    assert robot.within_limits(solution.joints).all()
    for q, pose, found in zip(solution.joints, poses, solution.found, strict=True):
        distance, angle = residuals(robot, q, pose, freedom)
        good = distance <= ROOM * solver.tolerances[0] and angle <= ROOM * solver.tolerances[1]
        assert good or not found


@pytest.mark.parametrize("name", FREEDOMS)
def test_the_nearest_allowed_pose_leaves_what_counts(robot: Robot, name: str) -> None:
    """A few degrees and centimetres off, where Euclidean and geodesic distance hardly differ."""
    freedom = FREEDOMS[name]
    joints = robot.sample(30, seed=4, collision_free=False)
    reached = robot.forward_kinematics(joints)
    rng = np.random.default_rng(2)
    targets = reached.copy()
    targets[:, :3] += rng.normal(0.0, 0.03, (30, 3))
    turns = quaternion_from_rotation_vector(rng.normal(0.0, 0.1, (30, 3)))
    targets[:, 3:] = quaternion_multiply(targets[:, 3:], turns)
    allowed = nearest_allowed(targets, reached, widths_of(freedom, 30))
    angles = rotation_angle(allowed[:, 3:], reached[:, 3:])
    for k, q in enumerate(joints):
        distance, angle = residuals(robot, q, targets[k], freedom)
        assert np.linalg.norm(allowed[k, :3] - reached[k, :3]) == pytest.approx(distance, abs=1e-12)
        assert angles[k] == pytest.approx(angle, abs=1e-3)
        assert angles[k] <= angle + 1e-9


@pytest.mark.parametrize("name", FREEDOMS)
def test_rows_of_the_jacobian_are_those_of_finite_differences(robot: Robot, name: str) -> None:
    room = new_freedom_room()
    room.widths[:] = FREEDOMS[name].widths
    at = new_linearisation(len(robot.chain.prismatic), robot.dof)
    rng, step = np.random.default_rng(5), 1e-6

    def error(q: np.ndarray, pose: np.ndarray) -> np.ndarray:
        find_error(robot.chain, q, pose, at)
        free_error(room, at)
        return at.error.copy()

    for q in robot.sample(5, seed=6, collision_free=False):
        pose = robot.forward_kinematics(q[None])[0]
        pose[:3] += rng.normal(0.0, 0.2, 3)
        # Near the target axis, but turned far about what is free.
        axis = np.isinf(FREEDOMS[name].about_rad) * 1.0 + rng.normal(0.0, 1e-4, 3)
        turn = quaternion_from_rotation_vector(axis)
        pose[3:] = quaternion_multiply(pose[3:], turn)
        set_target(pose, at)
        here = error(q, pose)
        find_jacobian(robot.chain, at)
        free_rows(room, at)
        J = at.jacobian.T.copy()
        for k in range(robot.dof):
            moved = np.eye(robot.dof)[k] * step
            slope = (error(q + moved, pose) - error(q - moved, pose)) / (2 * step)
            assert np.allclose(slope, -J[:, k], atol=3e-4), (name, k)
        assert (here[~room.counts] == 0.0).all()


def test_an_arm_of_five_joints_points_its_tool(tmp_path: Path) -> None:
    wide = '<limit lower="-2" upper="2" velocity="1" effort="1"/>'
    robot = load_robot(urdf=save(tmp_path, arm(5, limit=wide)))
    poses = robot.forward_kinematics(robot.sample(30, seed=1, collision_free=False))
    turn = quaternion_from_rotation_vector(np.array([0.0, 0.0, 1.0]))
    poses[:, 3:] = quaternion_multiply(poses[:, 3:], turn)
    solver = baselines.load("lm", robot, iterations=500)
    assert solver.solve(poses).found.mean() < 0.2
    assert solver.solve_partial(poses, Freedom.free_about("z")).found.mean() > 0.95


def test_joints_that_turn_for_ever_stay_near_the_guess(robot: Robot) -> None:
    """As of `solve`: within half a turn of the guess, however often that went round."""
    guess = robot.home + np.where(robot.endless, 6 * np.pi, 0.0)
    pose, solver = robot.forward_kinematics(robot.home[None]), baselines.load("lm", robot)
    for solution in (solver.solve_partial(pose, Freedom(), guess), solver.solve(pose, guess)):
        np.testing.assert_allclose(solution.joints[0], guess, atol=1e-9)


def test_each_pose_may_have_freedoms_of_its_own(robot: Robot) -> None:
    solver = baselines.load("lm", robot)
    pose = robot.forward_kinematics(robot.home[None])[0]
    mixed = [Freedom(), Freedom.position_only()]
    both = solver.solve_partial([pose, pose], mixed, initial=robot.home)
    assert both.found.all()
    assert (both.iterations == 0).all()
    with pytest.raises(FreedomError, match="one for each of 2 poses"):
        solver.solve_partial([pose, pose], mixed[:1])


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"along_m": (0.0, 0.0)}, "along_m as three widths"),
        ({"about_rad": (-0.1, 0.0, 0.0)}, "about_rad as three widths"),
        ({"about_rad": (FREE, FREE, 0.0)}, "one free axis"),
        ({"along_m": (np.nan, 0.0, 0.0)}, "along_m as three widths"),
    ],
)
def test_widths_that_are_none_are_refused(wrong: dict[str, tuple[float, ...]], words: str) -> None:
    with pytest.raises(FreedomError, match=words):
        Freedom(**wrong)  # type: ignore[arg-type]
    with pytest.raises(FreedomError, match="axis x, y or z"):
        Freedom.free_about("w")


def test_solvers_without_an_ability_say_so(robot: Robot) -> None:
    solver = baselines.load("pinocchio", robot)
    pose = robot.forward_kinematics(robot.home[None])
    assert solver.lacks("solve_partial") == "solver 'pinocchio' has no solve_partial"
    with pytest.raises(AbilityError, match="has no solve_partial"):
        solver.solve_partial(pose, Freedom())
    with pytest.raises(AbilityError, match="has no explain"):
        solver.explain(pose[0])
    near = baselines.load("lm", robot, max_jump=0.1)
    with pytest.raises(AbilityError, match=r"max_jump=0.1"):
        near.solve_all(pose[0], 3, apart=0.1)
