"""Stages at the smoke scale as the attacks run them: in a process forked from one that is warm.

A fork has the modules that a stage needs, so that a signal at a random moment meets work and not
imports.
"""

from __future__ import annotations

import io
import os
import re
import sys
import traceback
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.stages.graph import STAGES

ROBOT = "nico"  # the smallest robot that grasps and has a detector
COMMON = (
    f"robot={ROBOT}",
    "profile=smoke",
    "dataset.workers=1",
    "train.checkpoint_s=0.02",
    "evaluate.iterations=60",  # the same answers at any speed
    "evaluate.time_s=null",
    "evaluate.chunk=20",
    "evaluate.solvers=[cycleik,pinocchio]",
    "report.dpi=40",
    *(f"grasp.recording.{key}" for key in ("width=160", "height=120", "closeup=0")),
)
COMPARISON = tuple(  # by poses seen: seconds are of this machine, and many
    f"tune.comparison.{key}"
    for key in ("currency=poses", "amount=4000", "replicates=2", "candidates=[best,default]")
)
# Stage, what it is called here, and further overrides; later ones read what earlier ones leave.
RUNS: dict[str, tuple[str, ...]] = {
    "dataset": (),
    "tune": (),
    "train": (),
    "evaluate": (),
    "sample": ("model=null_space", "train.epochs=1"),
    "plan": (),
    "detector": (),
    "grasp": (),
    "grasp_agent": ("perception=camera", "agent=policy"),
    "compare_tuned": COMPARISON,
    "report": (),
}
# What a run leaves below the results folder, where that is not a folder of its name.
LEAVES = {
    "train": (f"train/{ROBOT}/tiny",),  # beside it lies what `sample` trained
    "report": ("tables", "figures", "report.html", "metrics.json"),
}
UNFINISHED = "checkpoint"
TEMPORARY = re.compile(r"^\.")  # locks, and files that are put in place when they are complete
# What differs between two undisturbed runs: clocks.
CLOCKS = re.compile(r"time|_us$|_ms$|_s$|elapsed|wall|threads|load")


def stage_of(run: str) -> str:
    """The stage of a run: some stages run twice."""
    return {"grasp_agent": "grasp", "compare_tuned": "compare-tuned"}.get(run, run)


def command(run: str, folder: Path) -> list[str]:
    """The arguments of a run, written to a results folder."""
    return [stage_of(run), *COMMON, *RUNS[run], f"results_dir={folder}"]


def leaves(run: str) -> tuple[str, ...]:
    """Files and folders below the results folder that a run writes."""
    return LEAVES.get(run, (run,))


def warm_up() -> None:
    """Import what every stage needs, so that forks begin with their work."""
    for stage in STAGES.values():
        import_module(stage.module)
    for name in ("pipeline.commands.run", "pybullet", "pinocchio", "matplotlib.pyplot"):
        import_module(name)


def forked(call: Callable[[], int], log: Path) -> int:
    """Run a call in a process of a group of its own; its status is what the call returns.

    Args:
        call: Runs in the fork.
        log: Receives what it says.

    Returns:
        The number of the process.
    """
    sys.stdout.flush()
    number = os.fork()
    if number:
        return number
    status = 70
    try:
        os.setsid()
        stream = os.open(log, os.O_CREAT | os.O_WRONLY | os.O_TRUNC)
        os.dup2(stream, 1)
        os.dup2(stream, 2)
        sys.stdout, sys.stderr = (
            io.TextIOWrapper(os.fdopen(each, "wb", 0), write_through=True) for each in (1, 2)
        )
        status = call()
    except BaseException:
        traceback.print_exc()
    finally:
        os._exit(status)


def run_main(arguments: list[str]) -> Callable[[], int]:
    """The command line as a call."""

    def call() -> int:
        from pipeline.__main__ import main

        return main(arguments)

    return call


def ended(number: int) -> int:
    """Wait for a process and return its status, negative for a signal."""
    return os.waitstatus_to_exitcode(os.waitpid(number, 0)[1])


def comparable(path: Path) -> Any:
    """What must be the same in two runs of a file; None for those that carry clocks or pictures."""
    from pipeline.data.tables import read_table

    if path.suffix == ".parquet":
        rows = read_table(path)
        return rows[[name for name in rows if not CLOCKS.search(str(name))]]
    if path.name == "trials.csv":
        rows = pd.read_csv(path)
        rows = rows[rows.state == "COMPLETE"]  # those whose worker was killed stand there as well
        rows = rows.dropna(axis="columns", how="all")
        return rows[[name for name in rows if name != "number" and not CLOCKS.search(str(name))]]
    if path.suffix in (".safetensors", ".npy") or path.name == "curve.csv":
        return path.read_bytes()
    return None


def difference(one: Path, other: Path, run: str) -> str:
    """The first difference of what a run left in two folders; empty where there is none."""
    for name in leaves(run):
        files = [_files(root / name) for root in (one, other)]
        if files[0].keys() != files[1].keys():
            return f"files differ: {sorted(files[0].keys() ^ files[1].keys())}"
        for key, path in files[0].items():
            contents = comparable(path), comparable(files[1][key])
            if isinstance(contents[0], pd.DataFrame):
                try:
                    pd.testing.assert_frame_equal(
                        *(each.reset_index(drop=True) for each in contents)
                    )
                except AssertionError as error:
                    return f"{key}: {' '.join(str(error).split())[:300]}"
            elif contents[0] != contents[1]:
                return f"{key}: other bytes"
    return ""


def _files(place: Path) -> dict[str, Path]:
    """Files of an artifact by their name in it, without temporary ones."""
    if place.is_file():
        return {place.name: place}
    found = (path for path in place.rglob("*") if path.is_file())
    return {str(p.relative_to(place)): p for p in found if not TEMPORARY.match(p.name)}


def half_written(root: Path) -> list[str]:
    """Files of a results folder that cannot be read whole."""
    return [f"{path.relative_to(root)}: {why}" for path in _visible(root) if (why := _wrong(path))]


def _visible(root: Path) -> list[Path]:
    return sorted(p for p in root.rglob("*") if p.is_file() and not TEMPORARY.match(p.name))


def _wrong(path: Path) -> str:
    """Why a file cannot be read, by a reader that is not the project's own where there is one."""
    import json

    import numpy as np
    import pyarrow.parquet as pq
    import yaml
    from PIL import Image
    from safetensors import safe_open

    readers: dict[str, Callable[[], object]] = {
        ".parquet": lambda: pq.read_table(path, use_threads=False),
        ".json": lambda: json.loads(path.read_text()),
        ".yaml": lambda: yaml.safe_load(path.read_text()),
        ".csv": lambda: pd.read_csv(path),
        ".npy": lambda: np.load(path),
        ".safetensors": lambda: safe_open(path, framework="np"),
        ".png": lambda: Image.open(path).load(),
        ".gif": lambda: Image.open(path).load(),
        ".pdf": lambda: _ends_with(path, b"%%EOF"),
        ".html": lambda: _ends_with(path, b"</html>"),
        ".mp4": lambda: _boxes(path),
    }
    try:
        readers.get(path.suffix, lambda: None)()
    except Exception as error:
        return f"{type(error).__name__}: {str(error)[:100]}"
    return ""


def _ends_with(path: Path, end: bytes) -> None:
    if not path.read_bytes().rstrip().endswith(end):
        raise ValueError(f"does not end with {end!r}")


def _boxes(path: Path) -> None:
    """Walk over the boxes of an MP4 file, whose lengths must end where the file does."""
    data, at, kinds = path.read_bytes(), 0, set()
    while at < len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        kinds.add(data[at + 4 : at + 8])
        at += size if size > 7 else len(data) + 1
    if at != len(data) or not {b"ftyp", b"moov", b"mdat"} <= kinds:
        raise ValueError("no whole MP4")
