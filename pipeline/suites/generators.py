"""Who generates which suite, and a suite as it is stored: rows, facts, checksum."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.data.tables import TableError, read_metadata, read_table, write_table
from pipeline.seeding import derive_seed
from pipeline.suites import postures
from pipeline.suites.cluttered import cluttered
from pipeline.suites.config import CLUTTERED, PARTIAL, TRACKING, UNREACHABLE, SuiteConfig
from pipeline.suites.drawing import SuiteError
from pipeline.suites.partial import partial
from pipeline.suites.problems import Problems, checksum, from_frame, to_frame
from pipeline.suites.tracking import tracking
from pipeline.suites.unreachable import unreachable
from pipeline.suites.warm import warm
from robots.checksums import sampling_checksum

if TYPE_CHECKING:
    from robots import Robot

GENERATORS: dict[str, Callable[..., Problems]] = {
    "uniform": postures.uniform,
    "at_limits": postures.at_limits,
    "near_singular": postures.near_singular,
    "boundary": postures.boundary,
    UNREACHABLE: unreachable,
    "warm": warm,
    TRACKING: tracking,
    PARTIAL: partial,
    CLUTTERED: cluttered,
}


@dataclass(frozen=True)
class Suite:
    """A suite of one robot.

    Attributes:
        name: As in conf/suite.
        generator: What is in it, a key of `GENERATORS`.
        version: Of what is in it; another generator is another version.
        problems: The problems.
        checksum: SHA-256 of their content (`pipeline.suites.problems.checksum`).
    """

    name: str
    generator: str
    version: int
    problems: Problems
    checksum: str


def suite_seed(root: int, robot: str, config: SuiteConfig) -> int:
    """Return the seed of a suite: another robot, suite or version has another one."""
    return derive_seed(root, "suite", config.name, config.version, robot)


def generate(robot: Robot, config: SuiteConfig, root: int) -> Suite:
    """Generate a suite; the same robot, configuration and root seed give the same checksum.

    Args:
        robot: Any robot, built in or added by its URDF.
        config: What is in it, and how much.
        root: Root seed of the run.

    Raises:
        NoProblemsError: The robot has no such problems, such as poses at limits without limits.
    """
    seed = suite_seed(root, robot.name, config)
    problems = GENERATORS[config.generator](robot, config, seed)
    content = checksum(to_frame(problems, robot))
    return Suite(config.name, config.generator, config.version, problems, content)


def suite_facts(robot: Robot, config: SuiteConfig, root: int) -> dict[str, Any]:
    """Return what decides what is in a suite; the same facts stand in its file."""
    unused = "poses" if config.generator == TRACKING else "trajectories"
    return {
        "suite": {key: value for key, value in asdict(config).items() if key != unused},
        "robot": robot.name,
        "robot_checksum": sampling_checksum(robot),
        "seed": root,
        "suite_seed": suite_seed(root, robot.name, config),
    }


def write_suite(
    path: Path, robot: Robot, config: SuiteConfig, root: int, made_by: dict[str, Any]
) -> Suite:
    """Generate a suite and write it as Parquet, with facts and checksum in its metadata.

    Args:
        path: The file.
        robot: The robot.
        config: What is in it.
        root: Root seed of the run.
        made_by: Provenance: versions and machine.
    """
    suite = generate(robot, config, root)
    facts = {**suite_facts(robot, config, root), "suite_checksum": suite.checksum, **made_by}
    write_table(path, to_frame(suite.problems, robot), facts)
    return suite


def read_suite(path: Path, robot: Robot, config: SuiteConfig, root: int) -> Suite:
    """Read a suite and check that it is whole and the one of this run.

    Raises:
        SuiteError: It is missing, damaged, or was made with other values, for another description
            of the robot, or by another version.
    """
    again = (
        f"make it again with: python -m pipeline suite robot={robot.name} suite={config.name}, and "
        "the other keys of this run"
    )
    try:
        facts, frame = read_metadata(path), read_table(path)
    except TableError as error:
        raise SuiteError(f"{error} ({again})") from error
    differing = suite_differs(facts, suite_facts(robot, config, root))
    if differing:
        raise SuiteError(f"{path} was made with other values of {', '.join(differing)}; {again}")
    content = checksum(frame)
    if content != facts.get("suite_checksum"):
        raise SuiteError(f"{path} was changed after it was written; {again}")
    problems = from_frame(frame, robot)
    return Suite(config.name, config.generator, config.version, problems, content)


def suite_differs(facts: dict[str, Any], wanted: dict[str, Any]) -> list[str]:
    """Return the names of the facts in which a file of a suite differs from a run."""
    inner, ours = facts.get("suite", {}), wanted["suite"]
    found = [f"suite.{key}" for key in ours if inner.get(key) != ours[key]]
    return [*found, *(key for key in wanted if key != "suite" and facts.get(key) != wanted[key])]
