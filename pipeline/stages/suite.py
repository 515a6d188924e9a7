"""Stage suite: a set of hard poses of a robot, with what is known of each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.progress import LOGGER
from pipeline.stages.inputs import artifacts, robot_of
from pipeline.suites.generators import write_suite

if TYPE_CHECKING:
    from pipeline.settings import Config


def run(config: Config) -> list[Path]:
    """Write the problems of ``suite=<name>``; the same values always give the same checksum."""
    robot = robot_of(config)
    path = artifacts(config).suite(robot.name, config.suite.name)
    with exclusive(path):
        suite = write_suite(path, robot, config.suite, config.seed, provenance.made_by())
    LOGGER.info(
        "suite %s, version %d, of %s: %d poses, checksum %s",
        *(suite.name, suite.version, robot.name, len(suite.problems), suite.checksum),
    )
    return [path]
