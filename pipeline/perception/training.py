"""Train the centre-point network on labelled images; a killed training continues from an epoch."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from torch import Tensor
from torch.nn import functional

from pipeline.learning.checkpoint import Progress, restore, save
from pipeline.perception.config import AugmentConfig, DetectorConfig
from pipeline.perception.network import CentreNetwork
from pipeline.perception.pictures import Pictures
from pipeline.perception.targets import loss, targets_of
from pipeline.progress import bar

SWAPPED = (0, 1, 4, 3, 2, 5)  # offsets of a mirrored picture: left and right change places


@dataclass(frozen=True)
class Trained:
    """The result of a training.

    Attributes:
        network: In evaluation mode.
        curve: A row an epoch: its number, mean loss and processor time [s].
    """

    network: CentreNetwork
    curve: list[dict[str, float]]


class DetectorTrainer:
    """One training run."""

    def __init__(
        self, config: DetectorConfig, pictures: Pictures, names: tuple[str, ...], seed: int
    ) -> None:
        """Make the network and the targets of all pictures.

        Args:
            config: Network, schedule, losses and augmentation.
            pictures: As large as the network's input.
            names: Classes.
            seed: Of weights, order and augmentation.
        """
        torch.manual_seed(seed)
        self.network = _laid_out(CentreNetwork(names, config.network), torch.channels_last)
        self._config, self._images, self._seed = config, pictures.images, seed
        size = (config.network.width, config.network.height)
        targets = [
            targets_of(labels, names, size, size[0] / camera.width, config.heatmap_sigma)
            for labels, camera in zip(pictures.labels, pictures.cameras, strict=True)
        ]
        self._heat = torch.from_numpy(np.stack([target.heat for target in targets]))
        self._offsets = torch.from_numpy(np.stack([target.offsets for target in targets]))
        self._known = torch.from_numpy(np.stack([target.known for target in targets]))
        self._optimizer = torch.optim.AdamW(
            self.network.parameters(), config.learning_rate, weight_decay=config.weight_decay
        )

    def fit(self, checkpoint: Path, digest: str, title: str) -> Trained:
        """Train to the end of the schedule.

        Args:
            checkpoint: File of the state after an epoch.
            digest: Names configuration and pictures; only a run with the same one may resume.
            title: Of the progress bar.
        """
        config, count = self._config, len(self._images)
        steps = -(-count // config.batch_size)
        found = restore(checkpoint, digest, self.network, self._optimizer)
        progress = found[0] if found else Progress()
        with bar(config.epochs * steps, "step", title, progress.step) as shown:
            for epoch in range(progress.step // steps, config.epochs):
                begin, total = time.process_time(), 0.0
                draw = np.random.default_rng([self._seed, epoch])
                for batch in np.array_split(draw.permutation(count), steps):
                    total += self._step(progress.step, steps * config.epochs, batch, draw)
                    progress.step += 1
                    shown.update()
                mean, core_s = total / steps, time.process_time() - begin
                progress.curve.append({"epoch": epoch + 1, "loss": mean, "core_s": core_s})
                shown.set_postfix_str(f"loss {mean:.3f}", refresh=False)
                if (epoch + 1) % config.checkpoint_epochs == 0:
                    save(checkpoint, digest, progress, self.network, self._optimizer, {})
        network = _laid_out(self.network, torch.contiguous_format)
        return Trained(network.eval().requires_grad_(False), progress.curve)

    def _step(self, step: int, steps: int, batch: np.ndarray, draw: np.random.Generator) -> float:
        """One step of the optimiser; returns the loss."""
        config = self._config
        for group in self._optimizer.param_groups:
            group["lr"] = config.learning_rate * _schedule(step, steps, config.warm_up_steps)
        images = torch.from_numpy(np.stack([self._images[i] for i in batch]))
        rows = torch.from_numpy(batch)
        heat, offsets, known = self._heat[rows], self._offsets[rows], self._known[rows]
        if draw.random() < 0.5:
            images, heat, known = images.flip(2), heat.flip(3), known.flip(2)
            offsets = offsets.flip(3)[:, list(SWAPPED)]
            offsets[:, 0] *= -1.0
        self.network.train()
        pixels = augmented(images, config.augment, int(draw.integers(2**31)))
        with torch.autocast("cpu", torch.bfloat16, enabled=config.precision == "bfloat16"):
            answer = self.network(pixels.contiguous(memory_format=torch.channels_last))
        logits, regressed = (part.float() for part in answer)
        error = loss(
            logits, regressed, (heat, offsets, known), config.offset_weight, config.box_weight
        )
        self._optimizer.zero_grad()
        error.backward()
        torch.nn.utils.clip_grad_norm_(self.network.parameters(), config.gradient_clip)
        self._optimizer.step()
        return float(error.detach())


def augmented(images: Tensor, config: AugmentConfig, seed: int) -> Tensor:
    """Change light, tint, noise and sharpness of pictures.

    Args:
        images: (N, height, width, 3), 0 to 255.
        config: How far.
        seed: Of what is drawn.

    Returns:
        (N, 3, height, width), 0 to 1.
    """
    generator = torch.Generator().manual_seed(seed)

    def drawn(*shape: int) -> Tensor:
        return torch.rand(shape, generator=generator)

    count = len(images)
    pixels = images.permute(0, 3, 1, 2).float() / 255.0
    soft = functional.avg_pool2d(pixels, 3, 1, 1, count_include_pad=False)
    pixels = torch.lerp(pixels, soft, config.blur * drawn(count, 1, 1, 1))
    gain = 1.0 + config.brightness * (2.0 * drawn(count, 1, 1, 1) - 1.0)
    pixels *= gain * (1.0 + config.tint * (2.0 * drawn(count, 3, 1, 1) - 1.0))
    # Fresh normal numbers for each pixel would take longer than the step of the network.
    noise = torch.randn(pixels[0].numel(), generator=generator)
    starts = torch.randint(len(noise), (count,), generator=generator).tolist()
    for picture, start, share in zip(pixels, starts, drawn(count).tolist(), strict=True):
        picture.add_(noise.roll(start).view_as(picture), alpha=config.noise * share)
    return pixels.clamp_(0.0, 1.0)


def _laid_out(network: CentreNetwork, layout: torch.memory_format) -> CentreNetwork:
    """The network with its numbers in another order; convolutions like channels last."""
    return network.to(memory_format=layout)  # type: ignore[call-overload]


def _schedule(step: int, steps: int, warm_up: int) -> float:
    """Share of the learning rate: a linear warm-up, then half a cosine to zero."""
    if step < warm_up:
        return (step + 1) / warm_up
    return 0.5 * (1.0 + math.cos(math.pi * (step - warm_up) / max(steps - warm_up, 1)))
