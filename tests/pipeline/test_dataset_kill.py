"""The dataset stage killed (SIGKILL) at several moments while it replaces an older dataset."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from pipeline.config import compose
from pipeline.data.dataset import DatasetError, read_split
from pipeline.data.tables import read_table
from pipeline.stages.running import run_stage
from robots import load_robot

FILES = ("train.parquet", "validation.parquet", "test.parquet", "card.json", "croissant.json")
COMMON = ["robot=nico", "profile=smoke", "dataset.workers=1"]
OLD = {"train": 300, "validation": 30, "test": 30}
NEW = {"train": 60_000, "validation": 20_000, "test": 20_000}  # large enough to be caught
DEADLINE_S = 60.0

Moment = Callable[[Path], bool]


def sampling_train(folder: Path) -> bool:
    return not (folder / "card.json").exists()


def writing_train(folder: Path) -> bool:
    return any(folder.glob(".train.*.partial.parquet")) or is_new(folder / "train.parquet")


def sampling_test(folder: Path) -> bool:
    return is_new(folder / "validation.parquet")


def is_new(path: Path) -> bool:
    return path.stat().st_size > 1_000_000


def arguments(root: Path, rows: dict[str, int]) -> list[str]:
    sizes = [f"dataset.{split}={count}" for split, count in rows.items()]
    return [*COMMON, *sizes, f"results_dir={root}"]


def dataset(root: Path, rows: dict[str, int]) -> Path:
    run_stage("dataset", compose(arguments(root, rows)))
    return root / "dataset" / "nico"


def bytes_of(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in FILES}


def kill_at(moment: Moment, root: Path) -> None:
    command = [sys.executable, "-m", "pipeline", "dataset", *arguments(root, NEW)]
    folder, deadline = root / "dataset" / "nico", time.monotonic() + DEADLINE_S
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as child:
        while not moment(folder) and child.poll() is None and time.monotonic() < deadline:
            time.sleep(0.0005)
        assert child.poll() is None, "the stage ended before it could be killed"
        os.kill(child.pid, signal.SIGKILL)
    assert child.returncode == -signal.SIGKILL


def test_dataset_killed_again_and_again_is_old_or_new_and_the_next_call_finishes(
    tmp_path: Path,
) -> None:
    robot = load_robot("nico")
    whole = bytes_of(dataset(tmp_path / "whole", NEW))
    folder = dataset(tmp_path / "cut", OLD)
    before = bytes_of(folder)
    for moment in (sampling_train, writing_train, sampling_test):
        kill_at(moment, tmp_path / "cut")
        for split in OLD:
            path = folder / f"{split}.parquet"
            assert path.read_bytes() in (before[path.name], whole[path.name])
            assert len(read_table(path)) in (OLD[split], NEW[split])
            with pytest.raises(DatasetError, match="make it again"):
                read_split(folder, split, robot)
        # The next turn goes on from what this one left.
    assert bytes_of(dataset(tmp_path / "cut", NEW)) == whole
    assert len(read_split(folder, "train", robot).poses) == NEW["train"]
    # A file that was being written when its process died may lie about, hidden; nothing reads it.
    assert {p.name for p in folder.iterdir() if not p.name.startswith(".")} == set(FILES)
