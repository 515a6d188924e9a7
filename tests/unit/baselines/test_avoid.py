"""Answers free of collision: what is found is free by another library, and keeps its pose."""

from __future__ import annotations

import numpy as np
import pytest

import baselines
from baselines import AbilityError, Solution
from baselines.avoid import refine_avoiding
from baselines.lm import LevenbergMarquardt
from pipeline import load_solver
from pipeline.suites.verdicts import CoalJudge
from robots import ObstacleError, Obstacles, Robot, Sphere, load_robot
from robots.rotations import rotation_angle

COUNT = 40
ELBOW = 3  # the driven joint that carries it
CLEARANCE_M = 0.01


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="module")
def poses(panda: Robot) -> np.ndarray:
    return panda.forward_kinematics(panda.sample(COUNT, seed=8))


@pytest.fixture(scope="module")
def sets(panda: Robot, poses: np.ndarray) -> list[Obstacles]:
    """A sphere for each pose where the elbow of the plain answer is."""
    plain = baselines.load("lm", panda).solve(poses).joints
    centres = [panda.clearance.centres(joints) for joints in plain]
    frames = panda.clearance.scene.shapes.frame
    elbow = int(np.flatnonzero(frames[frames >= 0] == ELBOW)[0])
    return [
        Obstacles(spheres=[Sphere(tuple(each[elbow]), 0.06)], clearance_m=CLEARANCE_M)
        for each in centres
    ]


def hold(robot: Robot, poses: np.ndarray, sets: list[Obstacles], solution: Solution) -> None:
    """Found means: the pose, free of itself, and clear of its obstacles, recomputed elsewhere."""
    coal, found = CoalJudge(robot), np.flatnonzero(solution.found)
    reached = robot.forward_kinematics(solution.joints)
    distance = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
    angle = rotation_angle(reached[:, 3:], poses[:, 3:])
    assert (distance[found] <= 1.001e-4).all()
    assert (angle[found] <= 1.001e-4).all()
    assert robot.within_limits(solution.joints).all()
    assert not robot.collision.exact.in_collision(solution.joints[found]).any()
    for row in found:
        assert coal.distance_mm(solution.joints[row], sets[row]) >= 1e3 * CLEARANCE_M - 1e-4
    assert [not reason for reason in solution.reason] == solution.found.tolist()


@pytest.mark.parametrize("name", ["lm", "cycleik_refined"])
def test_found_is_free(name: str, panda: Robot, poses: np.ndarray, sets: list[Obstacles]) -> None:
    solution = load_solver(name, panda).solve(poses, avoid=sets)
    hold(panda, poses, sets, solution)
    assert solution.found.mean() > 0.8
    plain = load_solver("lm", panda).solve(poses)
    assert panda.clearance.free(plain.joints, sets).mean() < 0.1


def test_a_row_does_not_depend_on_its_batch(
    panda: Robot, poses: np.ndarray, sets: list[Obstacles]
) -> None:
    solver = baselines.load("lm", panda)
    whole = solver.solve(poses, avoid=sets)
    for row in (0, 7, 31):
        alone = solver.solve(poses[row : row + 1], avoid=sets[row])
        np.testing.assert_array_equal(alone.joints[0], whole.joints[row])
        assert alone.iterations[0] == whole.iterations[row]


def test_plain_answers_are_the_same_before_and_after(
    panda: Robot, poses: np.ndarray, sets: list[Obstacles]
) -> None:
    solver = baselines.load("lm", panda)
    before = solver.solve(poses).joints
    solver.solve(poses, avoid=sets)
    np.testing.assert_array_equal(solver.solve(poses).joints, before)


def test_no_obstacles_ask_for_no_self_collision(panda: Robot) -> None:
    poses = panda.forward_kinematics(panda.sample(300, seed=9))
    solver = baselines.load("lm", panda)
    assert panda.in_collision(solver.solve(poses).joints).any()
    free = solver.solve(poses, avoid=Obstacles())
    assert free.found.mean() > 0.99
    assert not panda.in_collision(free.joints[free.found]).any()


def test_sliding_takes_fewer_iterations_than_filtering(
    panda: Robot, poses: np.ndarray, sets: list[Obstacles]
) -> None:
    slid = baselines.load("lm", panda).solve(poses, avoid=sets)
    filtered = baselines.load("lm", panda, avoid_steps=0).solve(poses, avoid=sets)
    hold(panda, poses, sets, filtered)
    both = slid.found & filtered.found
    assert slid.found.sum() >= filtered.found.sum()
    assert slid.iterations[both].mean() < filtered.iterations[both].mean()


def test_what_is_never_free_is_not_found(panda: Robot, poses: np.ndarray) -> None:
    walled = Obstacles(spheres=[Sphere(tuple(poses[0, :3]), 0.1)])
    solution = baselines.load("lm", panda, iterations=300).solve(poses[:1], avoid=walled)
    assert solution.reason == ("in collision",)
    reached = panda.forward_kinematics(solution.joints)
    np.testing.assert_allclose(reached[0, :3], poses[0, :3], atol=1e-4)


def test_what_is_taken_back_still_reaches_its_pose(
    panda: Robot, poses: np.ndarray, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second round has no start left: the answer of the first one stays."""
    solver = baselines.load("lm", panda)
    assert isinstance(solver, LevenbergMarquardt)
    once = solver.options(None)._replace(starts=1)
    seeds = panda.sample(COUNT, seed=8)[:, None]
    monkeypatch.setattr(panda.clearance, "free", lambda joints, sets: np.zeros(len(joints), bool))
    bound = once, solver.slide, solver.library, [Obstacles()] * COUNT
    refined = refine_avoiding(panda, poses, seeds, *bound)
    assert set(refined.solution().reason) == {"in collision"}
    reached = panda.forward_kinematics(refined.joints)
    np.testing.assert_allclose(reached[:, :3], poses[:, :3], atol=1e-4)


def test_what_is_out_of_reach_comes_as_near_as_without_obstacles(panda: Robot) -> None:
    far = panda.forward_kinematics(panda.home)
    far[:, 2] += 2.0
    solver = baselines.load("lm", panda, iterations=200)
    plain, free = solver.solve(far), solver.solve(far, avoid=Obstacles())
    assert free.reason == ("out of iterations",)
    first, second = (panda.forward_kinematics(each.joints)[0, :3] for each in (plain, free))
    distance, least = (np.linalg.norm(each - far[0, :3]) for each in (second, first))
    assert distance < least + 0.3


def test_a_limit_of_time_ends_the_search(panda: Robot, poses: np.ndarray) -> None:
    walled = Obstacles(spheres=[Sphere(tuple(poses[0, :3]), 0.1)])
    solver = baselines.load("lm", panda, time_s=1e-3, iterations=None)
    assert not solver.solve(poses[:1], avoid=walled).found[0]


def test_who_cannot_says_so(panda: Robot, poses: np.ndarray) -> None:
    with pytest.raises(AbilityError, match="'pinocchio' has no avoid"):
        baselines.load("pinocchio", panda).solve(poses, avoid=Obstacles())
    with pytest.raises(AbilityError, match="'lm' has no avoid with max_jump="):
        baselines.load("lm", panda, max_jump=0.1).solve(poses, avoid=Obstacles())
    with pytest.raises(ObstacleError, match="for all poses or 40, got 2"):
        baselines.load("lm", panda).solve(poses, avoid=[Obstacles()] * 2)
    with pytest.raises(ObstacleError, match="expected Obstacles"):
        baselines.load("lm", panda).solve(poses, avoid="a wall")
    assert len(baselines.load("lm", panda).solve(poses[:0], avoid=Obstacles())) == 0
