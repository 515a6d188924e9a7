"""Collision checks of every robot against PyBullet's on the same shapes."""

from __future__ import annotations

import numpy as np
import pytest

from robots import Robot, available_robots, load_robot
from tests.simulation import SharpShapes, Simulation

CONTACT_M = 1e-3  # a disagreement must lie this close to contact
AGREEMENT = 0.995
DRAWN_AT_ONCE = 20_000


def samples_of_each_kind(robot: Robot, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Uniform configurations (2 * count, dof), the first half free, and which ones collide."""
    free, hits, seed = [], [], 0
    while sum(map(len, free)) < count or sum(map(len, hits)) < count:
        joints = robot.sample(DRAWN_AT_ONCE, seed=seed, collision_free=False)
        collide = robot.in_collision(joints)
        free.append(joints[~collide])
        hits.append(joints[collide])
        seed += 1
        assert seed < 20, f"{robot.name}: of {seed * DRAWN_AT_ONCE} samples too few are of one kind"
    chosen = np.vstack([np.vstack(free)[:count], np.vstack(hits)[:count]])
    return chosen, np.arange(2 * count) >= count


@pytest.mark.parametrize("count", [100, pytest.param(2000, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", available_robots())
def test_pybullet_sees_the_same_collisions(name: str, count: int) -> None:
    robot = load_robot(name)
    samples, hits = samples_of_each_kind(robot, count)
    gaps = np.empty(len(samples))
    with Simulation(robot) as simulation:
        shapes = SharpShapes(simulation)
        for row, joints in enumerate(samples):
            simulation.move(joints)
            gaps[row] = shapes.gap(within=2 * CONTACT_M)
    others = np.flatnonzero((gaps <= 0.0) != hits)
    print(
        f"{name}: {len(others)} of {len(samples)} differ, at distances of "
        f"{np.round(1e3 * gaps[others], 4).tolist()} mm"
    )
    assert np.abs(gaps[others]).max(initial=0.0) < CONTACT_M
    assert len(others) <= (1.0 - AGREEMENT) * len(samples)
