"""Collision checks of every robot against PyBullet's on the same shapes."""

from __future__ import annotations

import numpy as np
import pybullet
import pytest
from numpy.typing import NDArray

from robots import Robot, available_robots, load_robot
from robots.urdf_reader import read_urdf
from tests.simulation import SharpShapes, Simulation

CONTACT_M = 1e-3  # a disagreement must lie this close to contact
AGREEMENT = 0.995
DRAWN_AT_ONCE = 20_000
# Samples of each kind with the share that must agree: among few a single one weighs too much.
COUNTS = [(100, 0.98), pytest.param(2000, AGREEMENT, marks=pytest.mark.slow)]
# Options of reading a URDF. Without a flag PyBullet makes meshes of cylinders, 1 mm too large.
IMPORTS = {
    "plain": 0,
    "implicit cylinders": pybullet.URDF_USE_IMPLICIT_CYLINDER,
}


def samples_of_each_kind(robot: Robot, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Uniform configurations (2 * count, dof), the first half free, and which ones collide."""
    free: list[np.ndarray] = []
    hits: list[np.ndarray] = []
    seed = 0
    while sum(map(len, free)) < count or sum(map(len, hits)) < count:
        joints = robot.sample(DRAWN_AT_ONCE, seed=seed, collision_free=False)
        collide = robot.in_collision(joints)
        free.append(joints[~collide])
        hits.append(joints[collide])
        seed += 1
        assert seed < 20, f"{robot.name}: of {seed * DRAWN_AT_ONCE} samples too few are of one kind"
    chosen = np.vstack([np.vstack(free)[:count], np.vstack(hits)[:count]])
    return chosen, np.arange(2 * count) >= count


def hold_against(
    label: str, gaps: NDArray[np.float64], hits: NDArray[np.bool_], share: float
) -> None:
    """Compare distances (N,) in m that PyBullet found with what we say of each sample (N,)."""
    others = np.flatnonzero((gaps <= 0.0) != hits)
    print(
        f"{label}: {len(others)} of {len(hits)} differ, at distances of "
        f"{np.round(1e3 * gaps[others], 4).tolist()} mm"
    )
    assert np.abs(gaps[others]).max(initial=0.0) < CONTACT_M
    assert len(others) <= (1.0 - share) * len(hits) + 1e-9


@pytest.mark.parametrize(("count", "share"), COUNTS)
@pytest.mark.parametrize("how", IMPORTS)
@pytest.mark.parametrize("name", available_robots())
def test_pybullet_sees_the_same_collisions(name: str, how: str, count: int, share: float) -> None:
    robot = load_robot(name)
    samples, hits = samples_of_each_kind(robot, count)
    gaps = np.empty(len(samples))
    with Simulation(robot, IMPORTS[how]) as simulation:
        for row, joints in enumerate(samples):
            simulation.move(joints)
            gaps[row] = simulation.gap(within=2 * CONTACT_M)
    hold_against(f"{name}, {how}", gaps, hits, share)


@pytest.mark.parametrize(("count", "share"), COUNTS)
@pytest.mark.parametrize("name", available_robots())
def test_pybullet_agrees_best_on_shapes_with_sharp_edges(
    name: str, count: int, share: float
) -> None:
    robot = load_robot(name)
    samples, hits = samples_of_each_kind(robot, count)
    gaps = np.empty(len(samples))
    with Simulation(robot) as simulation:
        shapes = SharpShapes(simulation)
        for row, joints in enumerate(samples):
            simulation.move(joints)
            gaps[row] = shapes.gap(within=2 * CONTACT_M)
    hold_against(f"{name}, sharp edges", gaps, hits, max(share, 0.9995))


@pytest.mark.parametrize("name", available_robots())
def test_no_cylinder_is_checked(name: str) -> None:
    """PyBullet's reading of a cylinder hangs on a flag; rows of spheres are alike everywhere."""
    robot = load_robot(name)
    checked = {link for pair in robot.collision.pairs for link in pair}
    urdf = read_urdf(robot.urdf_path)
    kinds = {shape.kind for link in checked for shape in urdf.links[link].collisions}
    assert kinds <= {"box", "sphere"}
