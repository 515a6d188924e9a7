"""Pose sets of Table I's robots, drawn on the processor once."""

from __future__ import annotations

import json
import multiprocessing
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.config import compose
from pipeline.data.dataset import split_seed
from pipeline.settings import Config
from robots import Robot, load_robot
from robots.sampling import ChunkExecutor, Samples, sample_configurations

ROBOTS = ("nicol", "fetch", "panda", "valkyrie", "nico")  # the longest training first
SPLITS = ("train", "validation", "test")


class Data:
    """The pose sets of the robots, made once on the processor."""

    def __init__(self, folder: Path, toy: bool) -> None:
        self.folder, self.toy = folder, toy
        self.configs = {name: self._config(name) for name in ROBOTS}
        self.robots = {name: load_robot(name) for name in ROBOTS}

    def make(self, workers: int, verdicts: Path | None) -> None:
        """Draw what is missing; the samples of `python -m pipeline dataset profile=paper`."""
        self.folder.mkdir(parents=True, exist_ok=True)
        with multiprocessing.get_context("spawn").Pool(workers) as pool:
            for name in ROBOTS:
                started = time.perf_counter()
                counts = {split: self._make(name, split, pool, verdicts) for split in SPLITS}
                print(f"data {name} {counts} {time.perf_counter() - started:.1f} s", flush=True)

    def load(self, name: str, split: str) -> NDArray[np.float64]:
        """Poses (N, 7) of a split."""
        return np.load(self.folder / f"{name}_{split}.npy")

    def _make(self, name: str, split: str, pool: Any, verdicts: Path | None) -> int:
        config, robot = self.configs[name], _robot(name, verdicts)
        path, count = self.folder / f"{name}_{split}.npy", getattr(config.dataset, split)
        if path.exists():
            return 0

        def draw(one: Any, numbers: Sequence[int]) -> Iterable[Samples]:
            chunk = partial(_drawn, name, one.func, one.keywords, verdicts)
            return pool.imap(chunk, numbers, chunksize=4)

        samples = sample_configurations(
            robot,
            count,
            seed=split_seed(config.seed, name, split),
            workspace_filter=config.robot.workspace_filter,
            executor=ChunkExecutor(draw, 0.0),
        )
        np.save(path, robot.forward_kinematics(samples.joints))
        return len(samples.joints)

    def _config(self, name: str) -> Config:
        config = compose([f"robot={name}", "profile=paper"])
        if not self.toy:
            return config
        sizes = replace(config.dataset, train=3000, validation=200, test=400)
        model = replace(config.model, hidden=[32, 32])
        return replace(config, dataset=sizes, model=model)


@cache
def _robot(name: str, verdicts: Path | None) -> Robot:
    """A robot, once a process; without coal where a file of verdicts takes its place."""
    robot = load_robot(name)
    if verdicts is not None:
        robot.collision.__dict__["exact"] = _Lookup(json.loads(verdicts.read_text()))
    return robot


def _drawn(
    name: str,
    draw: Callable[..., Samples],
    keywords: dict[str, Any],
    verdicts: Path | None,
    number: int,
) -> Samples:
    """A chunk of samples, drawn in another process."""
    return draw(_robot(name, verdicts), number, **keywords)


class _Lookup:
    """In the place of coal: which of the few undecided samples touch, from a file."""

    def __init__(self, touching: dict[str, bool]) -> None:
        self.touching = touching

    def answers(self, joints: NDArray[np.float64], pairs: Iterable[int]) -> Iterator[bool]:
        yield self.touching.get(np.asarray(joints, dtype=np.float64).tobytes().hex(), True)
