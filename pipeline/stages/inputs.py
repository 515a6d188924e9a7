"""What every stage starts from: the robot, the folders, and the pose sets of an earlier stage."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.artifacts import Artifacts
from pipeline.data.dataset import CARD, DatasetError, card_config
from pipeline.errors import ConfigError, MissingArtifactError
from pipeline.suites.generators import Suite, read_suite
from robots import Robot, available_robots, load_robot
from robots.locations import home
from robots.suggestions import unknown_name

if TYPE_CHECKING:
    from pipeline.settings import Config

DATA_KEYS = ("train", "validation", "test")


def artifacts(config: Config) -> Artifacts:
    """Return the folders of a run; a run elsewhere may read what its profile's folder has."""
    root = Path(config.results_dir).absolute()
    base = home() / "results" / config.profile
    return Artifacts(root, None if base == root else base)


def robot_of(config: Config) -> Robot:
    """Load the robot of a run.

    Raises:
        ConfigError: There is no robot of that name.
    """
    if config.robot.name not in available_robots():
        raise ConfigError(unknown_name("robot", config.robot.name, available_robots()))
    return load_robot(config.robot.name)


def dataset_of(config: Config) -> Path:
    """Return the folder of the robot's pose sets.

    Raises:
        DatasetError: There are pose sets, but made with another size, seed or filter.
        MissingArtifactError: There are none; `pipeline.stages.running` makes them before a stage.
    """
    folder = find_dataset(config)
    if folder is None:
        raise MissingArtifactError(
            f"there is no dataset of {config.robot.name} for these values; make it with: "
            f"python -m pipeline dataset robot={config.robot.name} profile={config.profile}"
        )
    return folder


def find_dataset(config: Config) -> Path | None:
    """Return the folder of the robot's pose sets for the run's values, None where there is none.

    Raises:
        DatasetError: The run's own folder has pose sets of another size, seed or filter.
    """
    folders = artifacts(config)
    own = folders.dataset(config.robot.name)
    wanted = dataset_facts(config)
    for folder in (folders.find(own.relative_to(folders.root) / CARD), own / CARD):
        if folder is None or not folder.exists():
            continue
        made = card_config(folder.parent)
        differing = {key for key in wanted if made.get(key) != wanted[key]}
        if not differing:
            return folder.parent
        if folder.parent == own:
            raise DatasetError(
                f"{own} was made with other values of {', '.join(sorted(differing))}; make it "
                f"again with `python -m pipeline dataset` and the same overrides"
            )
    return None


def suite_of(config: Config) -> Suite:
    """Return the suite of a run.

    Raises:
        SuiteError: It was made with other values, or is damaged.
        MissingArtifactError: There is none; `pipeline.stages.running` makes it before a stage.
    """
    robot, name = robot_of(config), config.suite.name
    path = find_suite(config)
    if path is None:
        raise MissingArtifactError(
            f"there is no suite {name} of {robot.name} yet; make it with: "
            f"python -m pipeline suite robot={robot.name} suite={name} profile={config.profile}"
        )
    return read_suite(path, robot, config.suite, config.seed)


def find_suite(config: Config) -> Path | None:
    """Return the file of the suite of a run, None where there is none."""
    folders = artifacts(config)
    own = folders.suite(config.robot.name, config.suite.name)
    return folders.find(own.relative_to(folders.root))


def dataset_facts(config: Config) -> dict[str, object]:
    """Return the part of the configuration that decides what is in the pose sets."""
    sizes = {key: getattr(config.dataset, key) for key in DATA_KEYS}
    return {**sizes, "seed": config.seed, "workspace_filter": config.robot.workspace_filter}
