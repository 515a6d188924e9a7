"""Every stage on a full disk, in a folder that takes nothing, and twice at the same time."""

from __future__ import annotations

import os
import random
import resource
import shutil
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.fuzzing.commands import RUNS, command, ended, forked, leaves, run_main
from benchmarks.fuzzing.folders import begin_anew, compared, undisturbed, unreadable

BAD_INPUT = 2
# A file system of the kernel, which takes no files even of root, whom modes do not stop.
READ_ONLY = Path("/sys/kernel")


@dataclass(frozen=True)
class Place:
    """Where an attack works: the undisturbed folder, the attacked one, and what runs say."""

    whole: Path
    cut: Path
    log: Path


def attack_disks(
    root: Path, count: int, chance: random.Random, names: Sequence[str] = ()
) -> Iterator[dict[str, Any]]:
    """Attack the disk of each run of the smoke scale and yield rows about it.

    Args:
        root: An empty folder to work in.
        count: Full disks of each run, each with another room for files, and pairs of runs.
        chance: Draws the rooms.
        names: Runs; all where left out.
    """
    place = Place(root / "whole", root / "cut", root / "log.txt")
    undisturbed(place.whole, place.log, names)
    attacks: dict[str, tuple[int, Callable[[], list[str]]]]
    for run in names or RUNS:
        attacks = {
            "full disk": (count, partial(_full, run, place, chance)),
            "read-only folder": (1, partial(_read_only, run, place)),
            "two at once": (max(1, count // 4), partial(_two, run, place, chance)),
        }
        for name, (times, attack) in attacks.items():
            wrong = [sentence for _ in range(times) for sentence in attack()]
            for sentence in wrong:
                print(f"{run}, {name}: WRONG: {sentence}", flush=True)
            yield {"attack": name, "target": run, "count": times, "bad": len(wrong)}


def _full(run: str, place: Place, chance: random.Random) -> list[str]:
    """Let no file grow beyond a room at which some file of the run does not fit, then have room."""
    begin_anew(run, place.whole, place.cut)
    sizes = [path.stat().st_size for name in leaves(run) for path in _files(place.whole / name)]
    room = int(max(sizes) * chance.random() ** 3)

    def limited() -> int:
        resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY))
        return run_main(command(run, place.cut))()

    with _piped(place.log) as end:
        status = ended(forked(limited, end))
    wrong = _sentence(status, place.log.read_text(errors="replace"), f"room for {room} bytes")
    return [*wrong, *unreadable(place.cut, place.log), *_again(run, place)]


@contextmanager
def _piped(log: Path) -> Iterator[Path]:
    """Yield a path that can be written to without a limit, and ends in a file."""
    reader, writer = os.pipe()
    with log.open("wb") as stream, subprocess.Popen(["cat"], stdin=reader, stdout=stream):
        os.close(reader)
        try:
            yield Path(f"/proc/self/fd/{writer}")
        finally:
            os.close(writer)


def _read_only(run: str, place: Place) -> list[str]:
    begin_anew(run, place.whole, place.cut)
    first = place.cut / Path(leaves(run)[0]).parts[0]
    if first.exists():  # of `train`, where other networks lie
        shutil.rmtree(first)
    place.cut.mkdir(exist_ok=True)
    first.symlink_to(READ_ONLY)
    status = ended(forked(run_main(command(run, place.cut)), place.log))
    wrong = _sentence(status, place.log.read_text(errors="replace"), "read-only")
    first.unlink()
    return [*wrong, *_again(run, place)]


def _two(run: str, place: Place, chance: random.Random) -> list[str]:
    begin_anew(run, place.whole, place.cut)
    logs = [place.log.with_name(f"log{number}.txt") for number in range(2)]
    numbers = []
    for log in logs:
        numbers.append(forked(run_main(command(run, place.cut)), log))
        time.sleep(chance.choice((0.0, 0.3)))
    statuses = [ended(number) for number in numbers]
    wrong = [f"one of two ended with {status}" for status in statuses if status]
    texts = [log.read_text(errors="replace") for log in logs]
    wrong += [f"a traceback of one of two: {t[-600:]}" for t in texts if "Traceback" in t]
    return wrong or compared(run, place.whole, place.cut, place.log)


def _again(run: str, place: Place) -> list[str]:
    status = ended(forked(run_main(command(run, place.cut)), place.log))
    if status:
        return [f"the next call ended with {status}: {place.log.read_text()[-600:]}"]
    return compared(run, place.whole, place.cut, place.log)


def _sentence(status: int, text: str, what: str) -> list[str]:
    lines = [line for line in text.replace("\r", "\n").splitlines() if line.startswith("error: ")]
    if status != BAD_INPUT or "Traceback" in text or len(lines) != 1:
        return [f"{what}: ended with {status}: {text[-600:]}"]
    return []


def _files(place: Path) -> list[Path]:
    return [place] if place.is_file() else [path for path in place.rglob("*") if path.is_file()]
