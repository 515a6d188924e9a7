"""Remembered configurations: the nearest ones are found, tried after the seeds, and help."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import baselines
from baselines.lm import LevenbergMarquardt
from baselines.lm_kernel import LmOptions
from baselines.refine import refine
from baselines.seed_library import ROTATION_SHARE, build_seed_library, find_distances, take_nearest
from robots import Robot, load_robot, rotations


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="module")
def poses(robot: Robot) -> NDArray[np.float64]:
    return robot.forward_kinematics(robot.sample(300, seed=9, collision_free=False))


@pytest.fixture(scope="module")
def options(robot: Robot) -> LmOptions:
    kernel = baselines.load("lm", robot)
    assert isinstance(kernel, LevenbergMarquardt)
    return kernel.options(None)


def test_the_nearest_come_in_the_order_of_the_metric(
    robot: Robot, poses: NDArray[np.float64]
) -> None:
    library = build_seed_library(robot, 50, 5, seed=0)
    known = robot.forward_kinematics(library.joints)
    goal = rotations.matrix_from_quaternion(poses[:1, 3:])[0]
    shift = (known[:, :3] - poses[0, :3]) / library.scale
    turn = ROTATION_SHARE * (rotations.matrix_from_quaternion(known[:, 3:]) - goal)
    wanted = (shift**2).sum(axis=1) + (turn**2).sum(axis=(1, 2))
    distances = np.empty(50, dtype=np.float32)
    find_distances(library, poses[0], goal, distances)
    np.testing.assert_allclose(distances, wanted, rtol=1e-5, atol=1e-6)
    taken = [take_nearest(distances) for _ in range(5)]
    assert taken == np.argsort(wanted)[:5].tolist()


def test_a_remembered_solution_is_found_at_once(robot: Robot, options: LmOptions) -> None:
    library = build_seed_library(robot, 50, 5, seed=0)
    targets = robot.forward_kinematics(library.joints)
    found = refine(robot, targets, np.empty((50, 0, 7)), options, library=library)
    assert found.found.all()
    assert np.all(found.starts == 1)
    # What is remembered is the solution itself, but for rows with a nearly equal neighbour.
    assert np.mean(found.iterations == 0) > 0.9
    np.testing.assert_array_equal(
        found.joints[found.iterations == 0], library.joints[found.iterations == 0]
    )


def test_seeds_come_first_and_memory_before_chance(
    robot: Robot, poses: NDArray[np.float64], options: LmOptions
) -> None:
    seeds = np.broadcast_to(np.asarray(robot.home), (len(poses), 1, 7)).copy()
    plain = refine(robot, poses, seeds, options)
    aided = refine(robot, poses, seeds, options, library=build_seed_library(robot, 2048, 6, seed=0))
    first = plain.starts == 1
    assert np.array_equal(first, aided.starts == 1)
    np.testing.assert_array_equal(plain.joints[first], aided.joints[first])
    assert aided.found.all()
    assert aided.iterations[~first].mean() < 0.8 * plain.iterations[~first].mean()


def test_more_neighbours_than_memory_and_rows_alone(
    robot: Robot, poses: NDArray[np.float64], options: LmOptions
) -> None:
    library = build_seed_library(robot, 3, 10, seed=0)
    assert library.neighbours == 3
    seeds = np.empty((len(poses), 0, 7))
    every = refine(robot, poses, seeds, options, library=library)
    assert every.found.all()
    one = refine(robot, poses[17:18], seeds[:1], options, library=library)
    np.testing.assert_array_equal(one.joints[0], every.joints[17])
    both = refine(robot, poses, seeds, options, threads=2, library=library)
    np.testing.assert_array_equal(both.joints, every.joints)
