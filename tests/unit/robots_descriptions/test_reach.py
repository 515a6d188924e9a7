"""Reach of every description: the published one, and the box that holds it."""

from __future__ import annotations

import numpy as np
import pytest

from robots import Robot, load_robot

# Tip positions over 200,000 uniform samples of the URDFs that the paper used, m.
REACH = {
    "panda": ([-0.9439, -0.9452, -0.4112], [0.9406, 0.9433, 1.2784]),
    "nico": ([-0.4912, -0.5748, 0.3432], [0.5048, 0.2853, 1.2274]),
    "nicol": ([-0.8899, -1.0942, 0.3014], [0.8433, 0.4719, 2.041]),
    "valkyrie": ([-0.9194, -0.971, -0.3996], [0.9584, 0.6653, 0.9776]),
    "fetch": ([-0.4396, -0.9218, -0.019], [0.9597, 0.9245, 1.9495]),
}
MARGIN = 0.03  # m, between what so many samples reach and what is published


@pytest.fixture(scope="module", params=REACH)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


@pytest.fixture(scope="module")
def reached(robot: Robot) -> np.ndarray:
    joints = robot.sample(200_000, seed=11, collision_free=False)
    return robot.forward_kinematics(joints)[:, :3]


def test_reach_is_the_published_one(robot: Robot, reached: np.ndarray) -> None:
    lower, upper = REACH[robot.name]
    assert np.abs(reached.min(axis=0) - lower).max() < MARGIN
    assert np.abs(reached.max(axis=0) - upper).max() < MARGIN


def test_the_workspace_holds_the_reach(robot: Robot, reached: np.ndarray) -> None:
    lower, upper = robot.workspace
    inside = (reached >= lower) & (reached <= upper)
    # NICOL's box cuts its reach down to the space over the table, the other boxes are the reach.
    expected = 0.2576 if robot.name == "nicol" else 1.0
    assert inside.all(axis=1).mean() == pytest.approx(expected, abs=0.005)
    if robot.name != "nicol":
        assert np.all((reached >= lower - MARGIN) & (reached <= upper + MARGIN))
