"""Runs a stage, and before it what the graph says that it reads and that is not there.

An artifact that is missing is made first, so that `train` and `evaluate` work in a fresh clone. One
that was made with other values is never replaced behind the user's back. Nothing that a stage
imports imports this module: stages are imported by the name that the graph has for them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from importlib import import_module
from pathlib import Path
from typing import cast

from baselines.registry import using
from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.learning.card import CARD, read_card
from pipeline.progress import LOGGER
from pipeline.settings import Config
from pipeline.solvers import is_neural, models_of
from pipeline.stages.best import trained_config
from pipeline.stages.graph import STAGES
from pipeline.stages.inputs import artifacts, find_dataset, find_suite
from pipeline.stages.shipped import agree, shipped_network

BOOKKEEPING = ("device", "kinematics", "checkpoint_s", "validations", "source")


def run_stage(name: str, config: Config) -> list[Path]:
    """Check a run, make what it reads where that is missing, run it and return what it wrote.

    Args:
        name: Of a stage of the graph.
        config: Of the run.
    """
    stage = STAGES[name]
    module = import_module(stage.module)
    with using(config.solver):
        if hasattr(module, "check"):
            module.check(config)
        if "dataset" in stage.inputs:
            make_dataset(config)
        if "suite" in stage.inputs:
            make_suite(config)
        config = with_weights(config, stage.solver_names(config))
        return cast(list[Path], module.run(config))


def make_dataset(config: Config) -> None:
    """Make the pose sets of a run where there are none.

    Raises:
        DatasetError: There are pose sets, but made with another size, seed or filter.
    """
    if find_dataset(config) is None:
        name = config.robot.name
        LOGGER.info("there is no dataset of %s for these values yet: making it", name)
        run_stage("dataset", config)


def make_suite(config: Config) -> None:
    """Make the suite of a run where there is none."""
    if find_suite(config) is None:
        LOGGER.info("there is no suite %s of %s yet", config.suite.name, config.robot.name)
        run_stage("suite", config)


def with_weights(config: Config, solvers: Iterable[str]) -> Config:
    """Return a run that knows the trained weights of its neural solvers, made where missing.

    Args:
        config: Of the run.
        solvers: Names of the solvers that it loads, neural or not.
    """
    own = {name for name in solvers if is_neural(name) and not config.solver[name]["weights"]}
    found = {name: weights_of(name, config) for name in sorted(own)}
    return replace(config, weights={**config.weights, **{k: str(v) for k, v in found.items()}})


def weights_of(solver: str, config: Config) -> Path:
    """Return the folder of the trained weights of a solver and train them where there are none.

    One that takes no network of the kind of the run's model gets the model that is meant for it.
    Weights in the run's own folder are taken as they are: whoever trained there, meant them. Those
    of the profile's folder are taken only if they were trained with this run's configuration.
    Where nobody requested a training of their own, the weights that come with the project will do.
    """
    kinds, model = models_of(solver)
    if config.model.kind not in kinds:
        config = _with_model(model, config)
    folders = artifacts(config)
    own = folders.train(config.robot.name, config.model.name)
    if (own / CARD).exists():
        return own
    found = folders.find(own.relative_to(folders.root) / CARD)
    if found is not None and _same_training(found.parent, trained_config(config)):
        return found.parent
    if (shipped := shipped_network(config)) is not None:
        LOGGER.info("no weights of %s were trained here: those of the project do", own.parent.name)
        return shipped
    LOGGER.info("there are no weights of %s for this run yet: training first", config.robot.name)
    run_stage("train", config)
    return own


def _with_model(name: str, config: Config) -> Config:
    """The run with another model of conf/model, trained as that one says."""
    meant = compose([f"robot={config.robot.name}", f"profile={config.profile}", f"model={name}"])
    train = replace(meant.train, epochs=config.train.epochs, device=config.train.device)
    return replace(config, model=meant.model, train=train)


def _same_training(folder: Path, config: Config) -> bool:
    """Whether weights were trained as ``config`` would; device and bookkeeping do not matter."""
    made = read_card(folder).get("config", {})
    wanted = to_dict(config)
    if made.get("seed") != wanted["seed"] or not agree(made.get("model", {}), wanted["model"]):
        return False
    ours = {key: value for key, value in wanted["train"].items() if key not in BOOKKEEPING}
    return agree(made.get("train", {}), ours)
