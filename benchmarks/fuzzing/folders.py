"""Results folders of the attacks: made undisturbed, made anew for a run, checked and compared."""

from __future__ import annotations

import re
import shutil
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.fuzzing.commands import RUNS, command, ended, forked, leaves, run_main, warm_up

UNFINISHED = "checkpoint"
TEMPORARY = re.compile(r"^\.")  # locks, and files that are put in place when they are complete
# What differs between two undisturbed runs: clocks.
CLOCKS = re.compile(r"time|_us$|_ms$|_s$|elapsed|wall|threads|load")


def undisturbed(whole: Path, log: Path, names: Sequence[str]) -> dict[str, float]:
    """Run what the named runs read, and themselves, undisturbed; return the seconds of each.

    Args:
        whole: The results folder.
        log: Receives what the runs say.
        names: Runs; all for none.
    """
    warm_up()
    times = {}
    needed = list(RUNS)[: 1 + max(list(RUNS).index(name) for name in names or RUNS)]
    for run in needed:
        began = time.monotonic()
        status = ended(forked(run_main(command(run, whole)), log))
        times[run] = time.monotonic() - began
        if status:
            raise SystemExit(f"{run} undisturbed ended with {status}: {log.read_text()[-2000:]}")
        print(f"{run}: {times[run]:.1f} s undisturbed", flush=True)
    return times


def begin_anew(run: str, whole: Path, cut: Path) -> None:
    """Make a results folder with all that a run reads and nothing that it writes."""
    if cut.exists():
        shutil.rmtree(cut)
    if run == "dataset":  # nothing else need be there
        return
    shutil.copytree(whole, cut)
    for place in (cut / name for name in (*leaves(run), UNFINISHED)):
        shutil.rmtree(place) if place.is_dir() else place.unlink(missing_ok=True)


def unreadable(cut: Path, log: Path) -> list[str]:
    """Sentences about visible files that are not whole."""
    if not cut.exists():
        return []
    return [f"half-written: {what}" for what in _said(partial(_say_half_written, cut), log)]


def compared(run: str, whole: Path, cut: Path, log: Path) -> list[str]:
    """Sentences about what a finished run left that an undisturbed one does not."""
    found = _said(partial(_say_difference, whole, cut, run), log)
    left = [f"left behind: {path.relative_to(cut)}" for path in cut.rglob("*.partial*")]
    return [*(f"another result: {what}" for what in found), *unreadable(cut, log), *left]


def _said(call: Callable[[], int], log: Path) -> list[str]:
    """Lines that a call prints in a fork: the parent must not start threads of libraries."""
    status = ended(forked(call, log))
    lines = log.read_text().splitlines()
    return lines if status == 0 else [f"the check itself failed: {lines[-3:]}"]


def _say_half_written(root: Path) -> int:
    print("\n".join(half_written(root)), end="")
    return 0


def _say_difference(one: Path, other: Path, run: str) -> int:
    print(difference(one, other, run), end="")
    return 0


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
                        *(each.reset_index(drop=True) for each in contents),
                        check_dtype=path.suffix != ".csv",  # beside a trial without values
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
