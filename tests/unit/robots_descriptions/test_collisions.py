"""Collisions of every description: the pairs that are allowed, and how often it collides."""

from __future__ import annotations

import pytest

from robots import Robot, load_robot

# Least and largest share of uniform configurations that should collide.
COLLIDING = {
    "panda": (0.05, 0.25),
    "nico": (0.01, 0.10),
    "nicol": (0.30, 0.45),
    "valkyrie": (0.005, 0.04),
    "fetch": (0.10, 0.20),
}
# Pairs that no search finds, but an explanation allows.
BY_HAND = {"fetch": {(frozenset(("base_link", "bellows_link2")), "slides-inside")}}


@pytest.fixture(scope="module", params=COLLIDING)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


def test_home_is_free_and_some_samples_collide(robot: Robot) -> None:
    assert not robot.in_collision(robot.home)[0]
    share = robot.in_collision(robot.sample(2000, seed=1, collision_free=False)).mean()
    least, most = COLLIDING[robot.name]
    assert least < share < most


def test_allowed_pairs_are_those_found_or_explained(robot: Robot) -> None:
    listed = robot.description.allowed_collisions
    assert listed is not None
    pairs = {(frozenset(pair[:2]), pair[2]) for pair in listed}
    found = {(frozenset(pair[:2]), pair[2]) for pair in robot.find_allowed_collisions()}
    assert pairs == found | BY_HAND.get(robot.name, set())
