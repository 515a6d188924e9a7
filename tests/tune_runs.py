"""Searches as processes that tests start, watch through the study, and kill."""

from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Collection
from pathlib import Path

import optuna
import pandas as pd
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from optuna.trial import FrozenTrial, TrialState

from pipeline.tuning.journal import WORKER
from pipeline.tuning.study import ABANDONED
from tests.toy import TOY

DEADLINE_S = 600.0  # for a machine that has much else to do
# Trials of some tenths of a second, so that a kill lands in the middle of one.
RUN = [
    *TOY,
    "tune.epochs=25",
    "tune.pruner.kind=none",
    "train.kinematics=pytorch_kinematics",  # nothing to compile
]
Look = Callable[[], list[FrozenTrial]]


def start(*overrides: str) -> subprocess.Popen[bytes]:
    """Start `python -m pipeline tune`; its log is read when it has ended."""
    command = [sys.executable, "-m", "pipeline", "tune", *RUN, *overrides]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def ended(search: subprocess.Popen[bytes]) -> str:
    """Wait until a search ends well and return its log."""
    _, log = search.communicate(timeout=DEADLINE_S)
    text = log.decode(errors="replace")
    assert search.returncode == 0, text
    return text


def in_journal(folder: Path) -> Look:
    """Return how to look at the trials of the one study that grows in a results folder."""

    def look() -> list[FrozenTrial]:
        journals = list((folder / "checkpoint").glob("tune-*.log"))
        if not journals or not journals[0].stat().st_size:
            return []
        storage = JournalStorage(JournalFileBackend(str(journals[0])))
        names = optuna.get_all_study_names(storage)
        return optuna.load_study(study_name=names[0], storage=storage).get_trials() if names else []

    return look


def kill_a_worker(
    look: Look, generator: random.Random, at: int, spared: int = 0, dead: Collection[int] = ()
) -> int:
    """Kill (SIGKILL) a worker in the middle of a trial, once so many trials are complete.

    Args:
        look: Returns the trials.
        generator: Picks the worker.
        at: Complete trials to wait for.
        spared: A process that is left alone.
        dead: Trials cut off before, which a server takes for running until heartbeats are missed.

    Returns:
        The number of the trial that was cut off.
    """
    deadline = time.monotonic() + DEADLINE_S
    while time.monotonic() < deadline:
        trials = look()
        done = sum(trial.state == TrialState.COMPLETE for trial in trials)
        running = [
            trial
            for trial in trials
            if trial.state == TrialState.RUNNING
            and trial.number not in dead
            and process_of(trial) not in (0, spared)
        ]
        if done >= at and running:
            trial = generator.choice(running)
            time.sleep(generator.uniform(0, 0.1))
            # Held before it is killed: it may have ended its trial meanwhile.
            os.kill(process_of(trial), signal.SIGSTOP)
            time.sleep(0.05)  # what it has sent is written by then
            if look()[trial.number].state == TrialState.RUNNING:
                os.kill(process_of(trial), signal.SIGKILL)
                return trial.number
            os.kill(process_of(trial), signal.SIGCONT)
        time.sleep(0.02)
    raise AssertionError("no worker was in a trial in time")


def process_of(trial: FrozenTrial) -> int:
    """Return the process that runs a trial, 0 before it has signed."""
    token = trial.user_attrs.get(WORKER)
    return 0 if token is None else int(token.split("-")[-2])


def check_total(folder: Path, total: int, cut_off: int) -> pd.DataFrame:
    """Hold trials.csv to what a study must be after kills.

    Args:
        folder: Results folder.
        total: Requested trials.
        cut_off: Trials whose worker was killed.
    """
    trials = pd.read_csv(folder / "tune" / "nico" / "trials.csv")
    finished = trials[trials.state.isin(["COMPLETE", "PRUNED"])]
    lost = trials[trials.state == "FAIL"]
    assert len(finished) == total
    assert finished.objective.notna().all()
    assert len(lost) == cut_off
    assert lost.empty or (lost.reason == ABANDONED).all()
    assert len(trials) == total + len(lost)  # none is running, none came too many
    assert trials.number.tolist() == list(range(len(trials)))  # none is lost, none is there twice
    drawn = finished[finished.drawn]
    assert drawn.learning_rate.is_unique  # no draw repeats but those of trials that were cut off
    assert trials.drawn.value_counts()[False] in range(1, 2 + len(lost))  # the start, tried again
    return trials
