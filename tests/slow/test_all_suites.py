"""Every suite of every robot has the content that its version had."""

from __future__ import annotations

import pytest

from pipeline.config import group_choices
from pipeline.suites.generators import generate
from robots import available_robots, load_robot
from tests.suites import config_of, known_checksums

pytestmark = pytest.mark.slow
OTHERS = [name for name in available_robots() if name != "panda"]  # that one is in tests/unit


@pytest.mark.parametrize("suite", group_choices("suite"))
@pytest.mark.parametrize("name", OTHERS)
def test_a_version_has_the_content_that_it_had(name: str, suite: str) -> None:
    made = generate(load_robot(name), config_of(suite), 0)
    assert known_checksums(name, suite, made.version) == [made.checksum]
