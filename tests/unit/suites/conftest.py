"""A two-link arm, a suite of it that can be checked by hand, and the settings of an evaluation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline.evaluation.config import EvaluateConfig
from pipeline.suites.generators import Suite
from pipeline.suites.problems import Problems, checksum, reached, to_frame
from robots import Robot, load_robot
from tests.evaluation import evaluate_config

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


@pytest.fixture(scope="session")
def arm() -> Robot:
    return load_robot(urdf=TWO_LINK)


def suite(robot: Robot, problems: Problems, name: str = "warm") -> Suite:
    return Suite(name, name, 3, problems, checksum(to_frame(problems, robot)))


@pytest.fixture
def warm(arm: Robot) -> Suite:
    """Five targets with a start each, 0.1 rad away."""
    joints = np.array([[0.1, 0.5], [0.2, 1.0], [-1.0, 0.7], [1.5, -0.9], [0.4, 2.0]])
    return suite(arm, reached(arm, joints, "near", joints + 0.1))


@pytest.fixture
def followed(arm: Robot) -> Suite:
    """Two trajectories, of three and of two waypoints."""
    joints = np.array([[0.1, 0.5], [0.12, 0.52], [0.15, 0.55], [1.0, -1.0], [1.02, -1.01]])
    start = np.full_like(joints, np.nan)
    start[[0, 3]] = joints[[0, 3]]
    further = {
        "trajectory": np.array([0, 0, 0, 1, 1]),
        "step": np.array([0, 1, 2, 0, 1]),
        "rate_hz": np.full(5, 100.0),
    }
    return suite(arm, reached(arm, joints, "plain", start, **further), "tracking")


@pytest.fixture
def evaluate() -> EvaluateConfig:
    return evaluate_config(pinned=False, chunk=2)
