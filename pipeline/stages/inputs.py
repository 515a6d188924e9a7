"""What a stage starts from: the robot, the folders, and artifacts of earlier stages.

An artifact that is missing is made first, so that `train` and `evaluate` work in a fresh clone. One
that was made with other values is never replaced behind the user's back.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from baselines import Solver
from pipeline.artifacts import Artifacts
from pipeline.config import compose, to_dict
from pipeline.data.dataset import CARD, DatasetError, card_config
from pipeline.errors import ConfigError, choices
from pipeline.learning.weights import CARD as WEIGHTS_CARD
from pipeline.learning.weights import read_card, shipped_weights
from pipeline.progress import LOGGER
from pipeline.provenance import ROOT
from pipeline.settings import Config
from pipeline.solvers import is_neural, load_solver, models_of
from pipeline.stages import run_stage
from pipeline.tuning.best import read_best
from robots import Robot, available_robots, load_robot

if TYPE_CHECKING:
    from pipeline.perception.detection import Detector

DATA_KEYS = ("train", "validation", "test")
BOOKKEEPING = ("device", "kinematics", "checkpoint_s", "validations", "source")


def artifacts(config: Config) -> Artifacts:
    """Return the folders of a run; a run elsewhere may read what its profile's folder has."""
    root = Path(config.results_dir)
    root = root if root.is_absolute() else ROOT / root
    base = ROOT / "results" / config.profile
    return Artifacts(root, None if base == root else base)


def robot_of(config: Config) -> Robot:
    """Load the robot of a run.

    Raises:
        ConfigError: There is no robot of that name.
    """
    if config.robot.name not in available_robots():
        raise ConfigError(choices("robot", config.robot.name, available_robots()))
    return load_robot(config.robot.name)


def dataset_of(config: Config) -> Path:
    """Return the folder of the robot's pose sets and make them where there are none.

    Raises:
        DatasetError: There are pose sets, but made with another size, seed or filter.
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
    LOGGER.info("there is no dataset of %s for these values yet: making it", config.robot.name)
    run_stage("dataset", config)
    return own


def dataset_facts(config: Config) -> dict[str, object]:
    """Return the part of the configuration that decides what is in the pose sets."""
    sizes = {key: getattr(config.dataset, key) for key in DATA_KEYS}
    return {**sizes, "seed": config.seed, "workspace_filter": config.robot.workspace_filter}


def weights_of(config: Config) -> Path:
    """Return the folder of the robot's trained weights and train them where there are none.

    Weights in the run's own folder are taken as they are: whoever trained there, meant them. Those
    of the profile's folder are taken only if they were trained with this run's configuration.
    Where nobody asked for a training of their own, the weights that come with the project will do.
    """
    folders = artifacts(config)
    own = folders.train(config.robot.name, config.model.name)
    if (own / WEIGHTS_CARD).exists():
        return own
    found = folders.find(own.relative_to(folders.root) / WEIGHTS_CARD)
    if found is not None and _same_training(found.parent, trained_config(config)):
        return found.parent
    shipped = shipped_weights(config.robot.name)
    if _as_shipped(shipped, config):
        LOGGER.info("no weights of %s were trained here: those of the project do", own.parent.name)
        return shipped
    LOGGER.info("there are no weights of %s for this run yet: training first", config.robot.name)
    run_stage("train", config)
    return own


def _as_shipped(folder: Path, config: Config) -> bool:
    """Whether the project's weights are of this network and nothing of training was overridden."""
    if not (folder / WEIGHTS_CARD).exists():
        return False
    names = [f"robot={config.robot.name}", f"profile={config.profile}"]
    plain = compose([*names, f"model={config.model.name}"])
    wanted, meant = to_dict(config), to_dict(plain)
    unchanged = all(wanted[key] == meant[key] for key in ("seed", "train", "model"))
    return unchanged and read_card(folder)["config"]["model"] == wanted["model"]


def _same_training(folder: Path, config: Config) -> bool:
    """Whether weights were trained as ``config`` would; device and bookkeeping do not matter."""
    made = read_card(folder).get("config", {})
    wanted = to_dict(config)
    if (made.get("seed"), made.get("model")) != (wanted["seed"], wanted["model"]):
        return False
    theirs, ours = made.get("train", {}), wanted["train"]
    return all(theirs.get(key) == ours[key] for key in ours if key not in BOOKKEEPING)


def detector_of(robot: Robot, config: Config) -> Detector:
    """Load the detector of a run: the one that this run trained, else the project's.

    `perception.weights` names another folder; an open-vocabulary model is the user's own.

    Raises:
        PerceptionError: There is none, or it is for another robot or for other things.
    """
    from pipeline.grasping.trial import required_scene  # PyBullet takes a second to load
    from pipeline.perception.loading import load_detector

    wanted = config.perception
    if wanted.weights is None and wanted.detector == "embedded":
        folders = artifacts(config)
        own = folders.detector(robot.name)
        found = folders.find(own.relative_to(folders.root) / WEIGHTS_CARD)
        wanted = replace(wanted, weights=str(found.parent) if found else None)
    return load_detector(wanted, robot, required_scene(config.grasp, robot.name).objects)


def solver_of(name: str, robot: Robot, config: Config) -> Solver:
    """Make a solver for a run; a neural one gets the weights of the run.

    One that takes no network of the kind of the run's model gets the model that is meant for it.
    """
    if not is_neural(name):
        return load_solver(name, robot)
    kinds, model = models_of(name)
    if config.model.kind not in kinds:
        config = _with_model(model, config)
    return load_solver(name, robot, weights_of(config))


def _with_model(name: str, config: Config) -> Config:
    """The run with another model of conf/model, trained as that one says."""
    meant = compose([f"robot={config.robot.name}", f"profile={config.profile}", f"model={name}"])
    train = replace(meant.train, epochs=config.train.epochs, device=config.train.device)
    return replace(config, model=meant.model, train=train)


def trained_config(config: Config) -> Config:
    """Return the run's configuration with training and architecture as they will be used.

    That is the run's own, or with `train.from=best` what the search found.

    Raises:
        MissingArtifactError: `train.from=best` before there was a search.
    """
    if config.train.source == "default":
        return config
    folders = artifacts(config)
    path = folders.need(
        folders.tune(config.robot.name) / "best.yaml",
        f"python -m pipeline tune robot={config.robot.name} profile={config.profile}",
    )
    train, model = read_best(path, config)
    return replace(
        config, train=replace(config.train, **train), model=replace(config.model, **model)
    )
