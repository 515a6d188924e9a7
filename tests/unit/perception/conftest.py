"""Studios of the two robots that see, built once."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from pipeline.config import compose
from pipeline.perception.studio import Studio
from robots import load_robot


@pytest.fixture(scope="session", params=["nico", "nicol"])
def studio(request: pytest.FixtureRequest) -> Iterator[Studio]:
    config = compose([f"robot={request.param}"])
    robot = load_robot(request.param)
    with Studio(robot, config.grasp, config.perception.eye, config.detector.visible) as built:
        yield built
