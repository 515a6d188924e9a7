"""Training of a network by the cycle pose -> joints -> pose (figure 2 of the paper)."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn
from tqdm import tqdm

from pipeline.learning import checkpoint
from pipeline.learning.batches import Batches
from pipeline.learning.checkpoint import Progress
from pipeline.learning.kinematics import make_kinematics
from pipeline.learning.losses import (
    PoseLoss,
    position_error_mm,
    rotation_error_deg,
    winner_takes_most,
)
from pipeline.learning.networks import IkNetwork
from pipeline.learning.rotation import quaternion_from_matrix
from pipeline.progress import LOGGER, bar
from pipeline.settings import TrainConfig
from robots import Robot

VALIDATION_BATCH = 4096
Report = Callable[[int, dict[str, float]], None]


class TrainingError(ValueError):
    """A training that cannot be started or cannot go on."""


@dataclass(frozen=True)
class Run:
    """What makes one training different from another.

    Attributes:
        seed: Seeds the order of the batches.
        digest: Names configuration, robot and data; a checkpoint of another one is not resumed.
        label: Shown at the progress bar.
        checkpoint: Where the state of an unfinished run is kept; None keeps none.
        report: Called at each validation with the step and its row; may raise to stop the run.
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
        network: Poses (N, 7) to hypotheses (N, K, dof); moved to the device.
        train: Losses, optimiser, schedule.
        run: Seed, checkpoint and label.
    """

    def __init__(self, robot: Robot, network: IkNetwork, train: TrainConfig, run: Run) -> None:
        self.device = pick_device(train.device)
        self.network = network.to(self.device)
        self.train = train
        self.run = run
        self.kinematics = make_kinematics(robot, train.kinematics, self.device)
        self.pose_loss = PoseLoss(train)
        # With a weight decay of zero AdamW is Adam.
        self.optimizer = torch.optim.AdamW(
            self.network.parameters(),
            lr=train.learning_rate,
            weight_decay=train.weight_decay,
            fused=True,
        )

    def fit(self, poses: NDArray[np.float64], validation: NDArray[np.float64]) -> Progress:
        """Train on poses (N, 7), validate on others (M, 7), and return the curve.

        A run that was killed goes on from its checkpoint and ends with the same bits as one that
        was not.

        Raises:
            TrainingError: The batch is larger than the set.
        """
        data = torch.as_tensor(poses, dtype=torch.float32, device=self.device)
        held_out = torch.as_tensor(validation, dtype=torch.float32, device=self.device)
        size = self.train.batch_size
        if len(data) < size:
            raise TrainingError(
                f"train.batch_size {size} is larger than the training set ({len(data)} poses): "
                "lower it or raise dataset.train"
            )
        batches = Batches(len(data), size, self.run.seed)
        total = batches.per_epoch * self.train.epochs
        progress = self._start(total)
        try:
            with bar(total * size, "pose", self.run.label, progress.step * size) as shown:
                self._loop(data, held_out, batches, progress, total, shown)
        except KeyboardInterrupt:
            self._save(progress)
            raise
        return progress

    def finish(self) -> None:
        """Remove the checkpoint, once the result is safe."""
        if self.run.checkpoint is not None:
            self.run.checkpoint.unlink(missing_ok=True)

    def _loop(
        self,
        data: Tensor,
        held_out: Tensor,
        batches: Batches,
        progress: Progress,
        total: int,
        shown: tqdm,
    ) -> None:
        count = self.train.validations
        marks = {max(1, round(total * (index + 1) / count)) for index in range(count)}
        saved = time.monotonic()
        while progress.step < total:
            self._step(data[batches.indices(progress.step)], progress, total)
            shown.update(self.train.batch_size)
            if progress.step in marks:
                self._validate(held_out, progress, total)
                row = progress.curve[-1]
                shown.set_postfix_str(
                    f"loss {row['loss']:.4f}, {row['validation_position_error_mm']:.1f} mm, "
                    f"{row['validation_rotation_error_deg']:.1f} deg"
                )
            if time.monotonic() - saved > self.train.checkpoint_s:
                self._save(progress)
                saved = time.monotonic()

    def _step(self, target: Tensor, progress: Progress, total: int) -> None:
        """One optimiser step; a gradient that is not finite changes nothing and is counted."""
        for group in self.optimizer.param_groups:
            group["lr"] = self.learning_rate(progress.step, total)
        shown = target
        if self.train.negate_input and progress.step % 2:
            shown = torch.cat((target[:, :3], -target[:, 3:]), dim=1)
        losses = self.pose_loss(*self._reached(shown), self._for_heads(target))
        share = self._head_share(progress.step / total)
        loss = winner_takes_most(losses.unflatten(0, (len(target), -1)), share)
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()
        norm = nn.utils.clip_grad_norm_(self.network.parameters(), self.train.gradient_clip)
        if torch.isfinite(norm):
            self.optimizer.step()
            progress.loss_sum += float(loss.detach())
            progress.loss_steps += 1
        else:
            progress.skipped += 1
        progress.step += 1

    def learning_rate(self, step: int, total: int) -> float:
        """Return the rate of a step: a linear warm-up, then linear to zero."""
        warm = min(1.0, (step + 1) / (self.train.warm_up_steps + 1))
        return self.train.learning_rate * warm * (1 - step / total)

    @torch.no_grad()
    def errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return errors (N,) in mm and deg of the best hypothesis for each of poses (N, 7)."""
        parts = [self._best_errors(part) for part in poses.split(VALIDATION_BATCH)]
        positions, rotations = zip(*parts, strict=True)
        return torch.cat(positions), torch.cat(rotations)

    @torch.no_grad()
    def validation_losses(self, poses: Tensor) -> tuple[float, float]:
        """Return position and rotation loss, unweighted, of the best hypotheses on poses (N, 7)."""
        position, rotation = self.pose_loss.parts(*self._reached(poses), self._for_heads(poses))
        both = self.train.position_weight * position + self.train.rotation_weight * rotation
        best = both.unflatten(0, (len(poses), -1)).argmin(dim=1, keepdim=True)
        means = [
            part.unflatten(0, (len(poses), -1)).gather(1, best) for part in (position, rotation)
        ]
        return float(means[0].mean()), float(means[1].mean())

    def _reached(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Tip frames of all hypotheses: positions (N K, 3) and rotations (N K, 3, 3)."""
        return self.kinematics(self.network(poses).flatten(0, 1))

    def _for_heads(self, poses: Tensor) -> Tensor:
        """Repeat poses (N, 7) for each hypothesis, (N K, 7)."""
        heads = self.network.heads
        return poses if heads == 1 else poses.repeat_interleave(heads, dim=0)

    def _head_share(self, done: float) -> float:
        """Weight of the mean of all heads: 1 at the start, `head_share` after a stretch."""
        until = self.train.head_share_until
        rest = max(0.0, 1 - done / until) if until > 0 else 0.0
        return self.train.head_share + (1 - self.train.head_share) * rest

    def _best_errors(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        position, rotation = self._reached(poses)
        targets = self._for_heads(poses)
        best = self.pose_loss(position, rotation, targets).unflatten(0, (len(poses), -1)).argmin(1)
        rows = torch.arange(len(poses), device=poses.device) * self.network.heads + best
        quaternion = quaternion_from_matrix(rotation[rows])
        return (
            position_error_mm(position[rows], poses[:, :3]),
            rotation_error_deg(quaternion, poses[:, 3:]),
        )

    def _validate(self, held_out: Tensor, progress: Progress, total: int) -> None:
        position, rotation = self.errors(held_out)
        done = progress.step
        row = {
            "step": done,
            "samples": done * self.train.batch_size,
            "loss": progress.loss_sum / max(progress.loss_steps, 1),
            "validation_position_error_mm": float(position.mean()),
            "validation_rotation_error_deg": float(rotation.mean()),
            "learning_rate": self.learning_rate(done, total),
        }
        progress.curve.append(row)
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
        LOGGER.info("going on from step %d of %d", found.step, total)
        return found

    def _save(self, progress: Progress) -> None:
        path = self.run.checkpoint
        if path is not None:
            checkpoint.save(path, self.run.digest, progress, self.network, self.optimizer)


def pick_device(name: str) -> torch.device:
    """Return the device that ``train.device`` names; ``auto`` takes an accelerator if there is one.

    Raises:
        TrainingError: CUDA is asked for and there is none.
    """
    if name == "cuda" and not torch.cuda.is_available():
        raise TrainingError("train.device=cuda, but torch sees no CUDA device: use auto or cpu")
    if name == "auto":
        name = "cuda" if torch.cuda.is_available() else "cpu"
    return torch.device(name)
