"""Robots of the leaderboard that are taken out of packages are those that its lines are about.

Nothing of theirs lies in git. Where a package is not installed, or in another version than the one
that the lines name, there is nothing to hold; the lines themselves need neither to be read.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import package_robots
from pipeline.config import group_choices
from pipeline.leaderboard.line import robot_source
from pipeline.suites.generators import generate
from robots import Robot
from robots.add import add_robot
from robots.description import find_description
from tests.suites import config_of, known_checksums

pytestmark = pytest.mark.slow
SOURCES = {
    "ur5": "example-robot-data 6.0.0: cmeel.prefix/share/example-robot-data/robots/ur_description/"
    "urdf/ur5_robot.urdf, base_link to tool0",
    "iiwa": "pybullet 3.2.7: pybullet_data/kuka_iiwa/model.urdf, "
    "lbr_iiwa_link_0 to lbr_iiwa_link_7",
}


@pytest.fixture(scope="module", params=package_robots.ROBOTS)
def robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    name, folder = request.param, tmp_path_factory.mktemp("robots")
    urdf, given = package_robots.urdf_of(name), package_robots.ROBOTS[name]
    if not urdf.exists():
        pytest.skip(f"no {urdf}: its package is not installed")
    add_robot(urdf, given.base, given.tip, name, Path(folder), Path(folder) / "conf")
    made = Robot(find_description(name, Path(folder)))
    if robot_source(made) != SOURCES[name]:
        pytest.skip(f"the lines are about {SOURCES[name]}, here is {robot_source(made)}")
    return made


@pytest.mark.parametrize("suite", group_choices("suite"))
def test_its_suites_are_those_of_the_committed_lines(robot: Robot, suite: str) -> None:
    made = generate(robot, config_of(suite), 0)
    assert known_checksums(robot.name, suite, made.version) == [made.checksum]
