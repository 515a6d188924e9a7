"""The arms of the zoo: what conf/zoo.yaml says of them, and the robots that they become."""

from __future__ import annotations

import re
import sysconfig
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from pipeline.checks import positive
from pipeline.data.files import Document, read_yaml
from pipeline.errors import ConfigError, PipelineError
from pipeline.locations import CONF_DIR
from robots import Robot, load_robot
from robots.add import add_robot
from robots.description import find_description

FILE = "zoo.yaml"
NAME = r"[a-z][a-z0-9_]*"  # of an arm, which becomes that of a robot
CHAIN = ("urdf", "base", "tip")  # what the file says of an arm out of a package


class MissingArmError(PipelineError):
    """The URDF of an arm is in no installed package."""


@dataclass(frozen=True)
class Arm:
    """One arm.

    Attributes:
        name: Its name in the zoo.
        urdf: Path below the folder of libraries; empty for a robot of robots/.
        base: Link that poses are given in.
        tip: Link whose pose is wanted.
    """

    name: str
    urdf: str = ""
    base: str = ""
    tip: str = ""


@dataclass(frozen=True)
class ZooConfig:
    """What conf/zoo.yaml holds.

    Attributes:
        minutes: Of one core, training of an arm's network.
        train: Poses in the training set of an arm.
        validation: Poses that the errors are followed on.
        poses: Poses that the descent is measured on.
        rounds: Of the measured times.
        seed: Of poses, weights and order.
    """

    minutes: float
    train: int
    validation: int
    poses: int
    rounds: int
    seed: int

    def __post_init__(self) -> None:
        """Refuse trainings and measurements of nothing."""
        for name in ("minutes", "train", "validation", "poses", "rounds"):
            positive(name, getattr(self, name))


def read_zoo(given: Mapping[str, str]) -> tuple[ZooConfig, dict[str, Arm]]:
    """Return sizes and arms of conf/zoo.yaml.

    Args:
        given: Sizes that stand in place of the file's, as they were typed.

    Raises:
        ConfigError: A size that is no number, or none that can be; an arm that says too much or
            too little.
        FileError: The file lacks a key.
    """
    content = Document(CONF_DIR / FILE, read_yaml(CONF_DIR / FILE))
    arms = {name: _arm(name, facts) for name, facts in content["arms"].items()}
    sizes: dict[str, Any] = {}
    for field in fields(ZooConfig):
        kind = float if field.name == "minutes" else int
        value = given.get(field.name, content[field.name])
        try:
            sizes[field.name] = kind(value)
        except ValueError:
            raise ConfigError(f"{field.name} must be a number, got {value!r}") from None
    try:
        return ZooConfig(**sizes), arms
    except ValueError as error:
        raise ConfigError(str(error)) from error


def _arm(name: str, facts: Any) -> Arm:
    """Make an arm of its entry: nothing for a robot of robots/, else all of `CHAIN`."""
    given = {} if facts is None else facts
    known = isinstance(given, dict) and set(given) in (set(), set(CHAIN))
    if not known or not re.fullmatch(NAME, str(name)):
        raise ConfigError(
            f"{CONF_DIR / FILE}: arm {name} must be small letters, digits and _, and have "
            f"{', '.join(CHAIN)}, or nothing for a robot of robots/; got {facts}"
        )
    return Arm(name, **given)


def robot_of_arm(arm: Arm, folder: Path) -> Robot:
    """Return the robot of an arm, which is brought in as `robot add` does where it is not yet.

    Args:
        arm: The arm.
        folder: Of the zoo's robots.

    Raises:
        MissingArmError: No installed package has its URDF.
        RobotError: The URDF cannot be used.
        ConfigError: The folder has a robot of that name with another chain.
    """
    if not arm.urdf:
        return load_robot(arm.name)
    path = Path(sysconfig.get_path("purelib")) / arm.urdf
    if not path.exists():
        raise MissingArmError(f"no installed package has {arm.urdf}: pip install '.[test]' does")
    if not (folder / arm.name).exists():
        add_robot(path, arm.base, arm.tip, arm.name, folder, folder / "conf")
    robot = Robot(find_description(arm.name, folder))
    if (robot.base, robot.tip) != (arm.base, arm.tip):
        raise ConfigError(
            f"{folder / arm.name} goes from {robot.base} to {robot.tip}, and {FILE} says "
            f"{arm.base} to {arm.tip}: remove that folder and {folder / 'conf' / arm.name}.yaml"
        )
    return robot
