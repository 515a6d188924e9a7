"""The best configuration of a search against Table I: trainings that cost the same.

What a training costs can be counted in three currencies: seconds of processor time, multiply-adds
of the network's layers (any machine), or poses seen (any network). One of them is the budget, and
every row has all three, so that a reader sees what the others would have said.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
import torch
from torch import nn

from pipeline.closure import source_tree
from pipeline.containers import to_dict
from pipeline.data.dataset import PoseSet
from pipeline.data.tables import TableError, read_table
from pipeline.learning.checkpoint import Progress
from pipeline.learning.config import ModelConfig, TrainConfig
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.factory import build_network
from pipeline.learning.networks import IkNetwork, parameter_count
from pipeline.learning.registry import declared_modules
from pipeline.learning.trainer import Trainer, TrainingRun
from pipeline.progress import LOGGER
from pipeline.provenance import digest, machine
from pipeline.seeding import derive_seed
from pipeline.tuning.best import read_best
from robots import Robot

if TYPE_CHECKING:
    from pipeline.settings import Config

# Of a training step to a forward pass: forward, gradient by the inputs, gradient by the weights.
PASSES = 3
WARM_UP_PART = 10  # of a short schedule no more than this part is spent on warming up
WARM_UP_STEPS, TIMED_STEPS, TIMED_S = 5, 20, 5.0
BEST, TABLE_ONE = "best", "table_one"
Keep = Callable[[pd.DataFrame], None]
Compose = Callable[[list[str]], "Config"]


@dataclass(frozen=True)
class Candidate:
    """A configuration that is trained.

    Attributes:
        name: best, default or table_one.
        train: Losses, optimiser, schedule.
        model: Architecture.
    """

    name: str
    train: TrainConfig
    model: ModelConfig


def load_candidates(config: Config, best: Path, compose: Compose) -> list[Candidate]:
    """Return the configurations that ``tune.comparison`` names.

    Args:
        config: The run: its own configuration is ``default``.
        best: best.yaml of the search.
        compose: Makes a configuration of overrides.

    Raises:
        PipelineError: The search was for another kind of model.
        ValueError: A name that is none of them.
    """
    made = []
    for name in config.tune.comparison.candidates:
        train, model = config.train, config.model
        if name == BEST:
            found, shape = read_best(best, config)
            train, model = replace(train, **found), replace(model, **shape)
        if name == TABLE_ONE:
            names = [f"robot={config.robot.name}", f"profile={config.profile}"]
            theirs = compose([*names, "experiment=table_one"])
            train, model = replace(theirs.train, device=config.train.device), theirs.model
        made.append(Candidate(name, train, model))
    return made


def run_comparison(
    robot: Robot,
    config: Config,
    chosen: list[Candidate],
    sets: tuple[PoseSet, PoseSet],
    path: Path,
    keep: Keep,
) -> pd.DataFrame:
    """Train every candidate with every seed and return one row a training.

    Candidates take turns, so that a machine that slows down slows all of them. Rows that are on
    disk already, of the same configuration and budget, are not made again.

    Args:
        robot: The robot.
        config: Budget, repetitions, root of the seeds.
        chosen: Who takes part.
        sets: Training and validation poses.
        path: Where the rows lie.
        keep: Called with all rows after each training.
    """
    kept = _kept(path)
    rows: list[dict[str, Any]] = []
    turns = [(number, who) for number in range(config.tune.comparison.replicates) for who in chosen]
    runs = [_run_digest(robot, config, who, number) for number, who in turns]
    for place, (replicate, candidate) in enumerate(turns):
        run = runs[place]
        # The best of a search may be the default: one run under two names.
        found = kept[(kept["run"] == run) & (kept["name"] == candidate.name)].to_dict("records")
        if found:
            rows += [{str(key): value for key, value in found[0].items()}]
            continue
        rate = next((row["poses_per_s"] for row in rows if row["name"] == candidate.name), None)
        made = _train(robot, config, candidate, sets, replicate, rate)
        rows.append({"robot": robot.name, "name": candidate.name, "run": run, **made})
        to_come = {
            (r, who.name) for r, (_, who) in zip(runs[place + 1 :], turns[place + 1 :], strict=True)
        }
        known = [key in to_come for key in zip(kept["run"], kept["name"], strict=True)]
        keep(pd.DataFrame([*rows, *kept[known].to_dict("records")]))
    return pd.DataFrame(rows)


def _kept(path: Path) -> pd.DataFrame:
    """Rows of trainings that ended; none where the file is damaged."""
    try:
        if path.exists():
            return read_table(path)
    except TableError as error:
        LOGGER.warning("%s: all trainings run anew", error)
    return pd.DataFrame({"run": [], "name": []}, dtype=str)


def multiply_adds(network: nn.Module) -> float:
    """Return the multiply-adds of a network's layers for one pose, forward.

    Every weight of a layer is used once for a pose; of a mixture of experts, those of one expert,
    and the distances to all cells.
    """
    if isinstance(network, Experts):
        layers = sum(weight[0].numel() for weight in network.weights)
        return float(layers + network.centres.numel())
    return float(sum(p.numel() for p in network.parameters() if p.dim() > 1))


def spend(train: TrainConfig, poses: float, available: int) -> TrainConfig:
    """Return a schedule that sees so many poses, in passes over as many as there are.

    Args:
        train: Batch size, and everything that stays.
        poses: To be seen, repeated ones included.
        available: Poses of the training set.
    """
    size = train.batch_size
    steps = max(1, round(poses / size))
    epochs = -(-steps * size // (available // size * size))
    per_epoch = max(1, round(steps / epochs))
    warm_up = min(train.warm_up_steps, steps // WARM_UP_PART)
    return replace(
        train, epochs=epochs, poses=per_epoch * size, validations=1, warm_up_steps=warm_up
    )


def _train(
    robot: Robot,
    config: Config,
    candidate: Candidate,
    sets: tuple[PoseSet, PoseSet],
    replicate: int,
    rate: float | None,
) -> dict[str, Any]:
    seed = derive_seed(config.seed, "contest", robot.name, replicate)
    torch.manual_seed(seed)
    network = build_network(robot, candidate.model)
    cost = PASSES * multiply_adds(network)
    comparison = config.tune.comparison
    budget_s, poses = None, sets[0]
    if comparison.currency == "seconds":
        # Processor time ends the training; how many poses that will be is only a guess.
        budget_s = comparison.amount
        rate = rate or _poses_per_second(robot, candidate, poses)
        train = spend(candidate.train, budget_s * rate, len(poses.poses))
    else:
        rate = float("nan")
        budget = comparison.amount / (cost if comparison.currency == "multiply_adds" else 1)
        train = spend(candidate.train, budget, len(poses.poses))
        poses = poses.first(train.poses)
    label = f"{candidate.name}, seed {replicate + 1} of {comparison.replicates}"
    LOGGER.info("%s: %d poses in %d passes", label, train.poses * train.epochs, train.epochs)
    trainer = Trainer(robot, network, train, TrainingRun(seed, "", label))
    progress = trainer.fit(poses, sets[1], budget_s=budget_s)
    position, rotation = trainer.objective.errors(trainer.tensor(sets[1].poses))
    return {
        "replicate": replicate,
        "seed": seed,
        "model": candidate.model.name,
        "hidden": " ".join(str(width) for width in candidate.model.hidden),
        "batch_size": train.batch_size,
        "learning_rate": train.learning_rate,
        "parameters": parameter_count(network),
        "currency": comparison.currency,
        "amount": comparison.amount,
        "poses_per_s": rate,
        "steps": progress.step,
        "poses_seen": progress.step * train.batch_size,
        "multiply_adds": progress.step * train.batch_size * cost,
        "train_s": progress.processor_s,
        "device": str(trainer.device),
        "position_error_mm": float(position.mean()),
        "rotation_error_deg": float(rotation.mean()),
        "success_10mm_20deg": float(((position < 10) & (rotation < 20)).double().mean()),
    }


def _poses_per_second(robot: Robot, candidate: Candidate, poses: PoseSet) -> float:
    """Guess how many poses a second of processor time trains: steps of a network thrown away."""
    network = build_network(robot, candidate.model)
    trainer = Trainer(robot, network, candidate.train, TrainingRun(0, "", "speed"))
    part = poses.first(min(len(poses.poses), 20 * candidate.train.batch_size))
    data, joints = trainer.tensor(part.poses), trainer.tensor(part.joints)
    if isinstance(network, IkNetwork):
        network.prepare(data)
    progress, size = Progress(), candidate.train.batch_size
    began, steps = time.process_time(), -WARM_UP_STEPS
    while steps < TIMED_STEPS or time.process_time() - began < TIMED_S:
        if steps == 0:
            _wait_for(trainer.device)
            began = time.process_time()
        first = (progress.step * size) % (len(data) - size + 1)
        trainer.step(data[first : first + size], joints[first : first + size], progress, 10**6)
        steps += 1
    _wait_for(trainer.device)
    return size * steps / (time.process_time() - began)


def _wait_for(device: torch.device) -> None:
    """Wait until an accelerator is idle: a captured step returns before it has run."""
    if device.type == "cuda":
        torch.cuda.synchronize(device)


def _run_digest(robot: Robot, config: Config, candidate: Candidate, replicate: int) -> str:
    """Name a training; seconds are those of this machine."""
    comparison = config.tune.comparison
    budget = [comparison.currency, comparison.amount, config.seed, replicate]
    place = machine() if comparison.currency == "seconds" else {}
    code = source_tree().digest(__name__, *declared_modules(candidate.model.kind))
    data = [config.dataset.train, config.dataset.validation, robot.urdf_checksum, place, code]
    return digest([to_dict(candidate.train), to_dict(candidate.model), budget, data])
