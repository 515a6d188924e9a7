"""Which trainings run on the accelerator, in which order."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from torch import Tensor

from benchmarks.accelerator.data import ROBOTS, Data
from pipeline.learning.fleet import FleetJob
from pipeline.seeding import derive_seed
from pipeline.settings import TrainConfig

HELD_OUT = 10_000  # validation poses of a curve
STABILITY_DRAWS, STABILITY_STEPS = 8, 1500
RATIOS = (0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # position weight per rotation weight
LOSSES, LOSS_ROBOTS, LOSS_SEEDS = ("smooth", "former"), ("nico", "panda"), (0, 1, 2)
CLIP = 10.0  # largest norm of the gradient where it is clipped
DRAWS = 40
GROUPS = ("table", "published", "nico", "stability", "search", "losses", "seeds")


class Plan:
    """Which trainings, in which order; jobs that depend on results wait for them."""

    def __init__(self, data: Data, device: torch.device, options: argparse.Namespace) -> None:
        self.data, self.device, self.options = data, device, options
        self.results: dict[str, dict[str, Any]] = {}
        self._poses: dict[tuple[str, str], Tensor] = {}

    def jobs(self) -> Iterator[FleetJob | None]:
        """Jobs of the groups, in the order that the options name them."""
        makers: dict[str, Callable[[], Iterator[FleetJob | None]]] = {
            "table": lambda: (self.table(name, 0) for name in ROBOTS),
            "published": lambda: iter([self.table("nico", 0, published=True)]),
            "nico": lambda: (self.table("nico", seed) for seed in (1, 2)),
            "seeds": lambda: (
                self.table(name, seed) for seed in (1, 2) for name in ROBOTS if name != "nico"
            ),
            "stability": self._stability,
            "search": self._search,
            "losses": self._losses,
        }
        for group in self.options.groups:
            yield from makers[group]()

    def poses(self, name: str, split: str) -> Tensor:
        """A split on the device, float32."""
        if (name, split) not in self._poses:
            values = self.data.load(name, split)
            values = values[:HELD_OUT] if split == "validation" else values
            self._poses[name, split] = torch.as_tensor(values, dtype=torch.float32).to(self.device)
        return self._poses[name, split]

    def _job(
        self,
        label: str,
        name: str,
        train: TrainConfig,
        seed: int,
        **more: Any,
    ) -> FleetJob:
        config = self.data.configs[name]
        poses = self.poses(name, "train")
        poses = poses[: train.poses] if train.poses else poses
        train = replace(train, precision=self.options.precision)
        more.setdefault("rounded_until", self.options.rounded_until)
        more.setdefault("model", config.model)
        return FleetJob(
            label=label,
            robot=self.data.robots[name],
            train=train,
            seed=derive_seed(config.seed, "train", name, "paper", seed),
            poses=poses,
            held_out=self.poses(name, "validation"),
            **more,
        )

    def table(self, name: str, seed: int, published: bool = False) -> FleetJob:
        """Training of a network of Table I, with the stable recipe or exactly as published."""
        train = self.data.configs[name].train
        if published:
            label, train = f"published/{name}/{seed}", _as_published(train)
        else:
            label = f"table/{name}/{seed}"
        return self._job(label, name, train, seed, urgent=seed == 0)

    def _stability(self) -> Iterator[FleetJob]:
        for name in ROBOTS:
            train = self.data.configs[name].train
            recipes = {
                "published": _as_published(train),
                "warm_up": train,
                "clipped": replace(train, warm_up_steps=0, gradient_clip=CLIP),
                "both": replace(train, gradient_clip=CLIP),
            }
            steps = 20 if self.data.toy else STABILITY_STEPS
            for recipe in self.options.recipes:
                for seed in range(STABILITY_DRAWS):
                    label = f"stability/{name}/{recipe}/{seed}"
                    yield self._job(label, name, recipes[recipe], seed, steps=steps, validations=3)

    def _search(self) -> Iterator[FleetJob]:
        name, config = "nico", self.data.configs["nico"]
        train = replace(config.train, epochs=1, poses=self.options.search_poses)
        yield self._job("search/table_one", name, train, 0)
        generator = np.random.default_rng(derive_seed(config.seed, "search", name))
        for number in range(DRAWS):
            layers = int(generator.integers(5, 10))
            widths = [int(10 * generator.integers(50, 351)) for _ in range(layers)]
            tanh_layers = int(generator.integers(1, 4))
            drawn = replace(
                train,
                batch_size=int(50 * generator.integers(2, 13)),
                learning_rate=float(1e-5 * generator.integers(1, 101)),
                position_weight=float(generator.integers(1, 21)),
                rotation_weight=float(generator.integers(1, 21)),
            )
            widths = [32] * layers if self.data.toy else widths
            model = replace(config.model, hidden=widths, tanh_layers=tanh_layers)
            yield self._job(f"search/{number}", name, drawn, 0, model=model)

    def _losses(self) -> Iterator[FleetJob | None]:
        cells = [(name, loss) for name in LOSS_ROBOTS for loss in LOSSES]
        for name, loss in cells:
            for ratio in RATIOS:
                yield self._loss_job(f"losses/ratio/{name}/{loss}/{ratio}", name, loss, ratio, 10)
        wanted = {
            cell: [f"losses/ratio/{cell[0]}/{cell[1]}/{ratio}" for ratio in RATIOS]
            for cell in cells
        }
        while not all(label in self.results for labels in wanted.values() for label in labels):
            yield None
        best = {
            cell: RATIOS[int(np.argmin([self.results[label]["score"] for label in labels]))]
            for cell, labels in wanted.items()
        }
        for name in LOSS_ROBOTS:
            for seed in LOSS_SEEDS:
                for loss, epochs in (("former", 100), ("former", 10), ("smooth", 10)):
                    label = f"losses/final/{name}/{loss}/{epochs}/{seed}"
                    yield self._loss_job(label, name, loss, best[name, loss], epochs, seed)

    def _loss_job(
        self, label: str, name: str, loss: str, ratio: float, epochs: int, seed: int = 0
    ) -> FleetJob:
        train = replace(
            self.data.configs[name].train,
            loss=loss,
            position_weight=ratio,
            rotation_weight=1.0,
            epochs=epochs,
            poses=self.options.loss_poses,
        )
        return self._job(label, name, train, seed)


def _as_published(train: TrainConfig) -> TrainConfig:
    return replace(train, warm_up_steps=0, gradient_clip=None)
