from pathlib import Path

import pytest

from robots import Robot, load_robot

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture(scope="session")
def two_link_urdf() -> Path:
    return FIXTURES / "two_link.urdf"


@pytest.fixture(scope="session")
def two_link(two_link_urdf: Path) -> Robot:
    return load_robot(urdf=two_link_urdf)


@pytest.fixture(scope="session")
def mixed() -> Robot:
    """Revolute, continuous, prismatic, mimic, fixed and stuck joints, skew axes, base not root."""
    return load_robot(urdf=FIXTURES / "mixed.urdf", base="bench", tip="tool")
