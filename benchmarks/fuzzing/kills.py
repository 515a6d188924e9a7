"""Every stage killed at random moments and started again: the same result, nothing half-written."""

from __future__ import annotations

import os
import random
import shutil
import signal
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from benchmarks.fuzzing.commands import RUNS, command, ended, forked, run_main
from benchmarks.fuzzing.folders import begin_anew, compared, undisturbed, unreadable

TERMINATED = "\nterminated; the same command goes on from here\n"
BAD_INPUT = 2
LONGEST_S = 600.0
MOST_STARTS = 3  # for each kill: some runs end before it
EARLIEST = 0.02  # of a run's time: before it there is no work


@dataclass
class Tally:
    """What happened to one run.

    Attributes:
        run: Its name.
        whole_s: Seconds that it takes undisturbed.
        kills: Starts that were killed.
        terminations: Starts that were ended by SIGTERM.
        ended: Starts that ended before the signal came.
        wrong: What went wrong, one sentence each.
    """

    run: str
    whole_s: float = 0.0
    kills: int = 0
    terminations: int = 0
    ended: int = 0
    wrong: list[str] = field(default_factory=list)


def kill_stages(
    root: Path, count: int, terminations: int, chance: random.Random, names: Sequence[str] = ()
) -> Iterator[dict[str, Any]]:
    """Kill each run of the smoke scale and yield a row about it.

    Args:
        root: An empty folder to work in.
        count: Kills (SIGKILL) of each run.
        terminations: SIGTERM of each run.
        chance: Draws the moments.
        names: Runs; all where left out.
    """
    whole, log = root / "whole", root / "log.txt"
    times = undisturbed(whole, log, names)
    for run in names or RUNS:
        tally = Tally(run, times[run])
        _attack(tally, whole, root / "cut", signal.SIGKILL, count, chance, log)
        _attack(tally, whole, root / "cut", signal.SIGTERM, terminations, chance, log)
        for sentence in tally.wrong:
            print(f"{run}: WRONG: {sentence}", flush=True)
        yield {
            "attack": "kill",
            "target": run,
            "count": tally.kills,
            "terminated": tally.terminations,
            "ended_before": tally.ended,
            "bad": len(tally.wrong),
        }


def _attack(
    tally: Tally,
    whole: Path,
    cut: Path,
    kind: signal.Signals,
    count: int,
    chance: random.Random,
    log: Path,
) -> None:
    run = tally.run
    begin_anew(run, whole, cut)
    done = 0
    for _ in range(MOST_STARTS * count):
        if done == count:
            break
        number = forked(run_main(command(run, cut)), log)
        status = _signalled(number, kind, tally.whole_s * chance.uniform(EARLIEST, 1.0))
        text = log.read_text(errors="replace")
        if "Traceback" in text:
            tally.wrong.append(f"{kind.name}: a traceback: {text[-600:]}")
        if status == 0:
            tally.ended += 1
            tally.wrong += compared(run, whole, cut, log)
            begin_anew(run, whole, cut)
        elif kind == signal.SIGKILL and status == -kind:
            done += 1
            tally.kills += 1
            tally.wrong += unreadable(cut, log)
        elif kind == signal.SIGTERM and status == BAD_INPUT and text.endswith(TERMINATED):
            done += 1
            tally.terminations += 1
            tally.wrong += unreadable(cut, log)
        else:
            tally.wrong.append(f"{kind.name}: ended with {status}: {text[-300:]}")
            done += 1
    status = ended(forked(run_main(command(run, cut)), log))
    if status:
        tally.wrong.append(f"after {kind.name}: ended with {status}: {log.read_text()[-600:]}")
    else:
        tally.wrong += compared(run, whole, cut, log)
    shutil.rmtree(cut)


def _signalled(number: int, kind: signal.Signals, after_s: float) -> int:
    """Send a signal to a process after some seconds, to all that it started if it is a kill."""
    deadline = time.monotonic() + after_s
    while time.monotonic() < deadline:
        found, status = os.waitpid(number, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    with suppress(ProcessLookupError):
        os.killpg(number, kind) if kind == signal.SIGKILL else os.kill(number, kind)
    began = time.monotonic()
    while time.monotonic() - began < LONGEST_S:
        found, status = os.waitpid(number, os.WNOHANG)
        if found:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
    os.killpg(number, signal.SIGKILL)
    os.waitpid(number, 0)
    return -int(signal.SIGALRM)
