"""Configurations that are remembered with their poses, to start from where other seeds have failed.

A random configuration has its tip anywhere; of a few thousand random ones, those whose tips came
closest to a target make far better starts. The search is a pass over all of them, short enough for
the few poses that need it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots import rotations
from robots.compiled import njit

if TYPE_CHECKING:
    from robots import Robot

FEATURES = 12  # three of the position, nine of the rotation matrix
# Of a number of the rotation matrix, against half of the workspace as unit of length.
ROTATION_SHARE = 0.5
TAKEN = np.float32(1e30)
LIBRARY_SEED = 0  # one solver is one function of its settings


class SeedLibrary(NamedTuple):
    """Remembered configurations of one robot; with M = 0 nothing is remembered.

    Attributes:
        joints: (M, dof) configurations [rad or m].
        features: (12, M) their poses, position and rotation matrix, scaled to one metric.
        centre: (3,) middle of the workspace box [m].
        scale: (3,) half of its size [m].
        neighbours: The nearest ones that are started from, in order, at most M.
    """

    joints: NDArray[np.float64]
    features: NDArray[np.float32]
    centre: NDArray[np.float64]
    scale: NDArray[np.float64]
    neighbours: int


def build_seed_library(robot: Robot, count: int, neighbours: int, seed: int) -> SeedLibrary:
    """Draw configurations uniformly and keep them with their poses.

    Args:
        robot: The robot.
        count: Configurations M; 0 remembers nothing.
        neighbours: How many of them are tried for one target.
        seed: Seed of the draw.
    """
    joints = robot.sample(count, seed=seed, collision_free=False)
    features = pose_features(robot, robot.forward_kinematics(joints)).T.astype(np.float32)
    return SeedLibrary(joints, features.copy(), *_metric(robot), min(neighbours, count))


def pose_features(robot: Robot, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return poses (N, 7) as points (N, 12) whose distance is how far they are from each other.

    Args:
        robot: The robot, whose workspace gives the unit of length.
        poses: (N, 7) in the base frame, x y z [m], then unit qw qx qy qz.
    """
    centre, scale = _metric(robot)
    matrices = rotations.matrix_from_quaternion(poses[:, 3:]).reshape(len(poses), 9)
    return np.hstack(((poses[:, :3] - centre) / scale, ROTATION_SHARE * matrices))


def _metric(robot: Robot) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Middle of the workspace box and half of its size [m]."""
    lower, upper = np.asarray(robot.workspace, dtype=np.float64)
    half = (upper - lower) / 2
    # The tip of a single joint may stay in a plane.
    return (lower + upper) / 2, np.where(half > 0.0, half, 1.0)


def nearest_remembered(library: SeedLibrary, pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the remembered configurations that a target (7,) is started from, (K, dof)."""
    distances = np.empty(len(library.joints), dtype=np.float32)
    goal = np.ascontiguousarray(rotations.matrix_from_quaternion(pose[3:]))
    find_distances(library, pose, goal, distances)
    return library.joints[np.argsort(distances, kind="stable")[: library.neighbours]]


def empty_seed_library(dof: int) -> SeedLibrary:
    """Return the memory of a solver that remembers nothing."""
    nothing = np.empty((FEATURES, 0), dtype=np.float32)
    return SeedLibrary(np.empty((0, dof)), nothing, np.zeros(3), np.ones(3), 0)


@njit(fastmath={"contract", "reassoc", "nsz"}, _nrt=False)
def find_distances(library, pose, goal, distances):  # type: ignore[no-untyped-def]
    """Write the squared distance of every remembered pose to a target.

    Args:
        library: `SeedLibrary`.
        pose: (7,) target.
        goal: (3, 3) its rotation.
        distances: (M,) float32, receives them.
    """
    distances[:] = 0.0
    for k in range(FEATURES):
        if k < 3:
            wanted = np.float32((pose[k] - library.centre[k]) / library.scale[k])
        else:
            wanted = np.float32(ROTATION_SHARE * goal[(k - 3) // 3, (k - 3) % 3])
        row = library.features[k]
        for m in range(row.shape[0]):
            difference = row[m] - wanted
            distances[m] += difference * difference


@njit(fastmath={"nnan", "nsz", "reassoc"}, _nrt=False)
def take_nearest(distances):  # type: ignore[no-untyped-def]
    """Return the index of the smallest distance and take it out, so that the next call goes on."""
    least = distances[0]
    for m in range(distances.shape[0]):  # without an index to keep, this loop runs in vectors
        least = min(least, distances[m])
    nearest = 0
    while distances[nearest] != least:
        nearest += 1
    distances[nearest] = TAKEN
    return nearest
