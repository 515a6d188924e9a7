"""One trial: draw a configuration, train it briefly, return its validation loss."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, cast

import torch
from optuna import Trial
from optuna.exceptions import TrialPruned
from torch import Tensor

from pipeline.artifacts import Artifacts
from pipeline.data.dataset import PoseSet
from pipeline.errors import PipelineError
from pipeline.learning.cycleik import METHOD
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.learning.factory import build_network
from pipeline.learning.networks import IkNetwork, parameter_count
from pipeline.learning.tracker import tracked
from pipeline.learning.trainer import Trainer, TrainingRun
from pipeline.seeding import derive_seed
from pipeline.tuning.sampling import DRAW, WHOLE
from pipeline.tuning.space import check, draw
from robots import Robot

if TYPE_CHECKING:
    from pipeline.settings import Config

JUDGED_AT_ONCE = 4096  # poses of the validation set, for the memory of wide layers
MM = 1e-3


@dataclass(frozen=True)
class TrialObjective:
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
        """Train one drawn configuration and return its objective.

        Raises:
            TrialPruned: It is among the worst where the pruner looks.
            ArithmeticError: The loss is no number any more.
        """
        tune = self.config.tune
        train, model = draw(trial, self.config)
        number = trial.user_attrs.get(DRAW, trial.number)
        seed = derive_seed(self.config.seed, "tune", self.robot.name, number)
        torch.manual_seed(seed)
        network = build_network(self.robot, model)
        trial.set_user_attr("parameters", parameter_count(network))
        poses = self.train.first(tune.poses)
        total = len(poses.poses) // train.batch_size * train.epochs
        values: list[float] = []

        def report(step: int, row: dict[str, float]) -> None:
            value = judge(trainer, held_out)
            values.append(value)
            if not math.isfinite(value):
                raise ArithmeticError(f"the validation loss is {value} after {step} steps")
            trial.report(value, round(WHOLE * step / total))
            _note_errors(trial, row)
            track(step, {**row, "objective": value})
            if step < total and trial.should_prune():
                raise TrialPruned

        run = TrainingRun(seed=seed, digest="", label=f"trial {trial.number}", report=report)
        trainer = Trainer(self.robot, network, train, run)
        held_out = trainer.tensor(self.validation.poses)
        judge = Judge(self.robot, self.config)
        name = f"tune {self.robot.name} {run.label}"
        folder = Artifacts(Path(self.config.results_dir).absolute()).tracker()
        try:
            with tracked(self.config.tracker, folder, name, trial.params) as track:
                trainer.fit(poses, self.validation)
            return values[-1]  # the last step is always reported
        finally:
            if trainer.device.type == "cuda":
                torch.cuda.empty_cache()  # what ran out of memory must not starve the next trial


@dataclass(frozen=True)
class Judge:
    """The objective of a network: one scale for all trials, whatever losses they train with.

    Attributes:
        robot: The robot.
        config: Fixed weights, and the losses of the run itself.
    """

    robot: Robot
    config: Config

    def __call__(self, trainer: Trainer, poses: Tensor) -> float:
        """Return the objective of a network on poses (N, 7)."""
        tune = self.config.tune
        weights = tune.objective_position, tune.objective_rotation
        if tune.objective == "errors":
            position, rotation = trainer.objective.errors(poses)
            means = MM * float(position.mean()), math.radians(float(rotation.mean()))
            return weights[0] * means[0] + weights[1] * means[1]
        fixed = replace(self.config.train, position_weight=weights[0], rotation_weight=weights[1])
        # Of a network with several hypotheses the best counts, best by these weights.
        network = cast(IkNetwork, trainer.network)  # what `check_search` lets through
        judged = CycleObjective(self.robot, network, fixed, trainer.device)
        value = 0.0
        for part in poses.split(JUDGED_AT_ONCE):
            losses = judged.validation_losses(part)
            share = len(part) / len(poses)
            value += share * (weights[0] * losses[0] + weights[1] * losses[1])
        return value


def check_search(config: Config) -> None:
    """Refuse a search that no trial of could end well.

    Raises:
        PipelineError: The objective is not for this kind of model, or the space is not possible.
    """
    if config.tune.objective == "losses" and config.model.kind not in METHOD.kinds:
        raise PipelineError(
            f"tune.objective=losses is for networks of kind {' and '.join(METHOD.kinds)}: "
            f"set tune.objective=errors for model.kind={config.model.kind}"
        )
    check(config)


def _note_errors(trial: Trial, row: dict[str, float]) -> None:
    for name in ("position_error_mm", "rotation_error_deg"):
        trial.set_user_attr(name, row[f"validation_{name}"])
