"""A two-link arm and the settings of a small evaluation."""

from pathlib import Path

import pytest

from robots import load_robot
from tests.evaluation import evaluate_config

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


@pytest.fixture(scope="module")
def robot():
    return load_robot(urdf=TWO_LINK)


@pytest.fixture
def config():
    return evaluate_config()
