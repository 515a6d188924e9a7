"""Training of a network for an objective: optimiser, schedule, checkpoints, validation."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from tqdm import tqdm

from pipeline.data.dataset import PoseSet
from pipeline.learning import checkpoint
from pipeline.learning.allocator import keep_freed_memory
from pipeline.learning.batches import Batches
from pipeline.learning.card import chain_facts
from pipeline.learning.checkpoint import Progress, State
from pipeline.learning.config import BFLOAT16, TrainConfig
from pipeline.learning.factory import make_objective
from pipeline.learning.networks import IkNetwork, parameter_count
from pipeline.learning.objective import Objective
from pipeline.learning.precision import MatmulPrecision, matmul_precision
from pipeline.learning.step import CapturedStep, EagerStep, TrainingError, TrainState, is_captured
from pipeline.progress import LOGGER, bar
from robots import Robot

# What an error counts when validations are compared: success in the paper is one of each.
POSITION_UNIT_MM, ROTATION_UNIT_DEG = 10.0, 20.0
Report = Callable[[int, dict[str, float]], None]


@dataclass(frozen=True)
class TrainingRun:
    """What makes one training different from another.

    Attributes:
        seed: Seeds the order of the batches.
        digest: Names configuration, robot and data; a checkpoint of another one is not resumed.
        label: Shown at the progress bar.
        checkpoint: Where the state of an unfinished run is kept; None keeps none.
        report: Called at each validation with the step and its row, and with those of before where
            a run goes on from its checkpoint; may raise to stop the run.
    """

    seed: int
    digest: str
    label: str
    checkpoint: Path | None = None
    report: Report | None = None


class Trainer:
    """One training of one network for one robot.

    Args:
        robot: Gives forward kinematics.
        network: Of a class that `make_objective` knows, or with an objective; moved to the device.
        train: Losses, optimiser, schedule.
        run: Seed, checkpoint and label.
        objective: Of the network, on the training's device; None takes that of its method.
    """

    def __init__(
        self,
        robot: Robot,
        network: nn.Module,
        train: TrainConfig,
        run: TrainingRun,
        objective: Objective | None = None,
    ) -> None:
        self.device = pick_device(train.device)
        if train.kinematics == "compiled" and self.device.type != "cpu":
            raise TrainingError(
                f"train.kinematics=compiled runs on the CPU, the training on {self.device}: "
                "use auto, or train.device=cpu"
            )
        if train.precision == BFLOAT16 and not getattr(network, "roundable", False):
            raise TrainingError(
                "train.precision=bfloat16 is for model=paper: use float32 or bfloat16_backward"
            )
        self.network = network.to(self.device)
        self.train = train
        self.run = run
        self.best: State = {}
        self._clock = 0.0
        self.objective = objective or make_objective(
            robot, self.network, train, self.device, run.seed
        )
        keep_freed_memory()
        self.products = MatmulPrecision(train, self.network, self.device)
        captured = is_captured(train, self.network, self.device)
        # With a weight decay of zero AdamW is Adam.
        self.optimizer = torch.optim.AdamW(
            self.network.parameters(),
            lr=train.learning_rate,
            weight_decay=train.weight_decay,
            fused=True,
            capturable=captured,
        )
        state = TrainState(
            self.objective, self.network, self.optimizer, self.products, train.max_gradient_norm
        )
        self._step: EagerStep | CapturedStep = (
            CapturedStep(state, train.batch_size) if captured else EagerStep(state)
        )

    def fit(
        self, train: PoseSet, validation: PoseSet, *, budget_s: float | None = None
    ) -> Progress:
        """Train on one set, validate on the poses of another, and return the curve.

        A run that was killed goes on from its checkpoint and ends with the same bits as one that
        was not.

        Args:
            train: Poses to train on.
            validation: Poses to validate on.
            budget_s: Seconds of processor time, over resumptions too, after which the run ends;
                its schedule follows that time, so how many steps it makes is known in the end and
                no two runs are alike. None ends after `TrainConfig.epochs`.

        Raises:
            TrainingError: The batch is larger than the set.
        """
        data = self.tensor(train.poses), self.tensor(train.joints)
        held_out = self.tensor(validation.poses)
        count, size = len(train.poses), self.train.batch_size
        if count < size:
            raise TrainingError(
                f"train.batch_size {size} is larger than the training set ({count} poses): "
                "lower it or raise dataset.train"
            )
        batches = Batches(count, size, self.run.seed, self.device)
        total = batches.per_epoch * self.train.epochs
        if isinstance(self.network, IkNetwork):
            self.network.prepare(data[0])
        progress = self._start(total)
        self._clock = time.process_time() - progress.processor_s
        try:
            with bar(total * size, "pose", self.run.label, progress.step * size) as shown:
                self._loop(data, held_out, batches, progress, total, shown, budget_s)
        except KeyboardInterrupt:
            self._save(progress)
            raise
        progress.processor_s = time.process_time() - self._clock
        return progress

    def states(self) -> dict[str, State]:
        """Return the tensors of the network after the last step and at the best validation."""
        last = _copied(self.network)
        return {"last": last, "best": self.best or last}

    def facts(self, robot: Robot) -> dict[str, Any]:
        """Return what a card says of the robot, the network's size and where it was trained."""
        return {
            **chain_facts(robot),
            "urdf_checksum": robot.urdf_checksum,
            "parameters": parameter_count(self.network),
            "device": str(self.device),
        }

    def tensor(self, values: NDArray[Any]) -> Tensor:
        """Return an array as a float32 tensor on the device."""
        return torch.as_tensor(values, dtype=torch.float32, device=self.device)

    def finish(self) -> None:
        """Remove the checkpoint, once the result is safe."""
        if self.run.checkpoint is not None:
            self.run.checkpoint.unlink(missing_ok=True)

    def _loop(
        self,
        data: tuple[Tensor, Tensor],
        held_out: Tensor,
        batches: Batches,
        progress: Progress,
        total: int,
        shown: tqdm,
        budget_s: float | None,
    ) -> None:
        saved = time.monotonic()
        while progress.step < (total := self._length(progress.step, total, budget_s)):
            chosen = batches.indices(progress.step)
            self.step(data[0][chosen], data[1][chosen], progress, total)
            shown.update(self.train.batch_size)
            # Validations at equal distances, the last one after the last step.
            due = total * (len(progress.curve) + 1) / self.train.validations
            if progress.step >= max(1, round(due)):
                self._validate(held_out, progress, total)
                row = progress.curve[-1]
                shown.set_postfix_str(
                    f"loss {row['loss']:.4f}, {row['validation_position_error_mm']:.1f} mm, "
                    f"{row['validation_rotation_error_deg']:.1f} deg"
                )
            if time.monotonic() - saved > self.train.checkpoint_s:
                self._save(progress)
                saved = time.monotonic()

    def _length(self, done: int, total: int, budget_s: float | None) -> int:
        """Steps of the run, as far as is known after those that are done."""
        if budget_s is None or done == 0:
            return total
        share = (time.process_time() - self._clock) / budget_s
        return done if share >= 1 else max(done + 1, round(done / share))

    def step(self, poses: Tensor, joints: Tensor, progress: Progress, total: int) -> None:
        """One optimiser step; a gradient that is not finite changes nothing and is counted."""
        self._step(poses, joints, progress, total, self.learning_rate(progress.step, total))

    def learning_rate(self, step: int, total: int) -> float:
        """Return the rate of a step: a linear warm-up, then linear to zero."""
        warm = min(1.0, (step + 1) / (self.train.warm_up_steps + 1))
        return self.train.learning_rate * warm * (1 - step / total)

    def _validate(self, held_out: Tensor, progress: Progress, total: int) -> None:
        with matmul_precision(self.products.forward):
            position, rotation = self.objective.errors(held_out)
        done = progress.step
        self._step.flush(progress)
        row = {
            "step": done,
            "samples": done * self.train.batch_size,
            "loss": progress.loss_sum / max(progress.loss_steps, 1),
            "validation_position_error_mm": float(position.mean()),
            "validation_rotation_error_deg": float(rotation.mean()),
            "learning_rate": self.learning_rate(done, total),
        }
        progress.curve.append(row)
        score = error_score(row)
        if score < progress.best_error:
            progress.best_error, progress.best_step = score, done
            self.best = _copied(self.network)
        progress.loss_sum, progress.loss_steps = 0.0, 0
        if self.run.report is not None:
            self.run.report(done, row)

    def _start(self, total: int) -> Progress:
        path = self.run.checkpoint
        if path is None:
            return Progress()
        found = checkpoint.restore(path, self.run.digest, self.network, self.optimizer)
        if found is None:
            return Progress()
        progress, best = found
        self.best = {name: value.to(self.device) for name, value in best.items()}
        LOGGER.info("going on from step %d of %d", progress.step, total)
        if self.run.report is not None:
            for row in progress.curve:
                self.run.report(int(row["step"]), row)
        return progress

    def _save(self, progress: Progress) -> None:
        path = self.run.checkpoint
        if path is not None:
            self._step.flush(progress)
            progress.processor_s = time.process_time() - self._clock
            checkpoint.save(
                path, self.run.digest, progress, self.network, self.optimizer, self.best
            )


def error_score(row: dict[str, float]) -> float:
    """Return one number for a row of the curve: its errors in units of the paper's success."""
    return (
        row["validation_position_error_mm"] / POSITION_UNIT_MM
        + row["validation_rotation_error_deg"] / ROTATION_UNIT_DEG
    )


def _copied(network: nn.Module) -> State:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}


def pick_device(name: str) -> torch.device:
    """Return the device that ``train.device`` names; ``auto`` takes an accelerator if there is one.

    Raises:
        TrainingError: CUDA is requested and there is none.
    """
    if name == "cuda" and not torch.cuda.is_available():
        raise TrainingError("train.device=cuda, but torch sees no CUDA device: use auto or cpu")
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(name)
