"""One trial: draw a configuration, train it briefly, return its validation loss."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from optuna import Trial
from optuna.exceptions import TrialPruned

from pipeline.data.dataset import PoseSet
from pipeline.learning.networks import build_network, parameter_count
from pipeline.learning.objective import CycleObjective
from pipeline.learning.trainer import Run, Trainer, TrainingError
from pipeline.seeding import derive_seed
from pipeline.settings import Config, ModelConfig, Range, TrainConfig
from robots import Robot


@dataclass(frozen=True)
class Objective:
    """What Optuna minimises: fixed weights on the validation losses (section IV-A of the paper).

    Attributes:
        robot: The robot.
        config: Ranges, epochs and weights of the search, and what is not searched.
        train: Poses to train on.
        validation: Poses to judge on.
    """

    robot: Robot
    config: Config
    train: PoseSet
    validation: PoseSet

    def __call__(self, trial: Trial) -> float:
        """Train one drawn configuration and return its objective; NaN and overflow are failures."""
        tune = self.config.tune
        train, model = draw(trial, self.config)
        seed = derive_seed(self.config.seed, "tune", self.robot.name, trial.number)
        torch.manual_seed(seed)
        network = build_network(self.robot, model)
        trial.set_user_attr("parameters", parameter_count(network))
        trial.set_user_attr("hidden", model.hidden)
        run = Run(seed=seed, digest="", label=f"trial {trial.number}")
        trainer = Trainer(self.robot, network, train, run)
        objective = trainer.objective
        if not isinstance(objective, CycleObjective):
            raise TrainingError(f"tune searches networks of the cycle, not model.kind={model.kind}")
        progress = trainer.fit(self.train.first(tune.poses), self.validation)
        trial.set_user_attr("position_error_mm", progress.curve[-1]["validation_position_error_mm"])
        trial.set_user_attr(
            "rotation_error_deg", progress.curve[-1]["validation_rotation_error_deg"]
        )
        held_out = trainer.tensor(self.validation.poses)
        position, rotation = objective.validation_losses(held_out)
        value = tune.objective_position * position + tune.objective_rotation * rotation
        if value != value:
            raise TrialPruned("the validation loss is NaN")
        return value


def draw(trial: Trial, config: Config) -> tuple[TrainConfig, ModelConfig]:
    """Draw training and architecture from the ranges of the search space.

    ``layers`` and ``neurons`` make the hidden layers, each of a width of its own; every other axis
    is a key of the groups train or model.
    """
    space = dict(config.tune.space)
    layers = int(_suggest(trial, "layers", space.pop("layers")))
    neurons = space.pop("neurons")
    hidden = [int(_suggest(trial, f"neurons_{i}", neurons)) for i in range(layers)]
    model = {**vars(config.model), "name": "trial", "hidden": hidden}
    train = dict(vars(config.train))
    train.update(epochs=config.tune.epochs, validations=1)
    for name, limits in space.items():
        group = model if name in model else train
        drawn = _suggest(trial, name, limits)
        group[name] = type(group[name])(drawn)
    return TrainConfig(**train), ModelConfig(**model)


def _suggest(trial: Trial, name: str, limits: Range) -> float:
    if limits.step and all(float(v).is_integer() for v in (limits.low, limits.high, limits.step)):
        return trial.suggest_int(
            name, int(limits.low), int(limits.high), step=int(limits.step), log=limits.log
        )
    return trial.suggest_float(
        name, limits.low, limits.high, step=limits.step or None, log=limits.log
    )
