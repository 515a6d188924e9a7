"""Studies: stopped anywhere they go on, no draw repeats, lost trials are made up for."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import pytest
from optuna import Study, Trial
from optuna.exceptions import TrialPruned
from optuna.trial import TrialState

from pipeline.config import compose
from pipeline.errors import PipelineError
from pipeline.settings import Config
from pipeline.tuning.journal import JournalStore, fetch_journal, keep_journal
from pipeline.tuning.outputs import trials_table
from pipeline.tuning.space import draw
from pipeline.tuning.storage import open_store
from pipeline.tuning.study import ABANDONED, REASON, count, open_study, run_trials, study_name
from tests.disks import REFUSAL, full_disk


@cache
def config(*overrides: str) -> Config:
    return compose(["profile=smoke", "robot=nico", "tune.trials=6", *overrides])


def objective(trial: Trial) -> float:
    train, model = draw(trial, config())
    return train.learning_rate * 1e3 + sum(model.hidden)


@contextmanager
def opened(path: Path, settings: Config) -> Iterator[tuple[JournalStore, Study]]:
    store = JournalStore(path)
    try:
        yield store, open_study(store, settings)
    finally:
        store.close()


def search(path: Path, settings: Config, what=objective) -> Study:
    with opened(path, settings) as (store, study):
        run_trials(store, study, what, settings)
    return study


def test_a_study_that_is_stopped_draws_what_an_uninterrupted_one_draws(tmp_path: Path) -> None:
    first = trials_table(search(tmp_path / "whole.log", config()))
    for total in (2, 5, 6):
        parts = search(tmp_path / "parts.log", config(f"tune.trials={total}"))
    assert len(first) == 6
    assert first.equals(trials_table(parts))
    assert first["learning_rate"].nunique() == 6


def test_draws_follow_from_the_seed_after_tpe_has_started_too(tmp_path: Path) -> None:
    many = ("tune.trials=16", "tune.startup=4")
    tables = [
        trials_table(search(tmp_path / f"{name}.log", config(*many, *more)))
        for name, more in (("a", []), ("b", []), ("c", ["seed=1"]))
    ]
    assert tables[0].equals(tables[1])
    assert not tables[0].learning_rate[1:].isin(tables[2].learning_rate[1:]).any()
    assert tables[0].learning_rate.is_unique


def test_a_trial_that_was_cut_off_fails_and_is_made_up_for(tmp_path: Path) -> None:
    with opened(tmp_path / "study.log", config()) as (_, study):
        study.ask()  # what a killed process leaves: a trial that runs for ever, here the first one
    study = search(tmp_path / "study.log", config())
    trials = study.get_trials()
    assert [trial.state for trial in trials].count(TrialState.COMPLETE) == 6
    assert [t.number for t in trials if t.state == TrialState.FAIL] == [0]
    assert trials[0].user_attrs[REASON] == ABANDONED
    # The start, which was cut off, was tried again as it was.
    assert trials[1].params == trials[0].system_attrs["fixed_params"]


def test_a_trial_of_a_living_worker_is_left_alone(tmp_path: Path) -> None:
    path, began, go_on = tmp_path / "study.log", threading.Event(), threading.Event()

    def slow(trial: Trial) -> float:
        began.set()
        assert go_on.wait(20)
        return objective(trial)

    settings = config("tune.trials=2")
    other = threading.Thread(target=search, args=(path, settings, slow))
    other.start()
    assert began.wait(20)
    fast = threading.Thread(target=search, args=(path, settings))
    fast.start()
    while count_of(path, settings).finished < 1:
        time.sleep(0.01)
    time.sleep(0.5)  # the fast one waits for the slow one, and does not begin a third trial
    assert (count_of(path, settings).finished, count_of(path, settings).running) == (1, 1)
    go_on.set()
    other.join()
    fast.join()
    tally = count_of(path, settings)
    assert (tally.finished, tally.running, tally.failed) == (2, 0, 0)


def count_of(path: Path, settings: Config):
    with opened(path, settings) as (_, study):
        return count(study)


def test_many_workers_never_begin_more_than_the_total(tmp_path: Path) -> None:
    settings = config("tune.trials=20")

    def flaky(trial: Trial) -> float:
        if trial.number % 5 == 3:
            raise RuntimeError("out of memory\nand more of it")
        if trial.number % 5 == 4:
            objective(trial)
            raise TrialPruned
        return objective(trial)

    workers = [
        threading.Thread(target=search, args=(tmp_path / "study.log", settings, flaky))
        for _ in range(4)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    table = trials_table(search(tmp_path / "study.log", settings, flaky))
    assert (table.state != "FAIL").sum() == 20
    assert table.number.tolist() == list(range(len(table)))
    assert (table.state == "FAIL").tolist() == (table.number % 5 == 3).tolist()
    assert (table.reason[table.state == "FAIL"] == "RuntimeError: out of memory").all()


def test_failing_trials_never_end_the_study_but_a_hopeless_one_says_so(tmp_path: Path) -> None:
    def never(trial: Trial) -> float:
        return float("nan")

    with pytest.raises(PipelineError, match=r"10 trials in a row failed: look at tune\.space"):
        search(tmp_path / "none.log", config(), never)
    with pytest.raises(PipelineError, match="3 trials in a row"):
        search(tmp_path / "three.log", config("tune.stop.failures=3"), never)
    table = trials_table(count_study(tmp_path / "three.log"))
    assert table.reason.tolist() == ["ArithmeticError: the objective is nan"] * 3


def count_study(path: Path) -> Study:
    with opened(path, config()) as (_, study):
        return study


def test_a_fault_of_the_code_is_not_taken_for_a_failed_trial(tmp_path: Path) -> None:
    def broken(trial: Trial) -> float:
        raise TypeError("a fault of ours")

    with pytest.raises(TypeError, match="a fault of ours"):
        search(tmp_path / "study.log", config(), broken)


def test_a_study_that_no_longer_gets_better_ends_early(tmp_path: Path) -> None:
    settings = config("tune.trials=50", "tune.stop.stall=7")
    study = search(tmp_path / "study.log", settings, lambda trial: float(trial.number))
    assert count(study).finished == 8


def test_another_space_or_seed_is_another_study() -> None:
    names = {
        study_name(config(*overrides))
        for overrides in ([], ["tune.space.hidden.high=4"], ["seed=1"], ["train.loss=former"])
    }
    assert len(names) == 4
    how = ["tune.trials=99", "tune.workers=3", "tune.storage=postgresql://host/studies"]
    assert study_name(config(*how)) in names


def test_half_a_line_of_a_killed_writer_is_cut_off(tmp_path: Path) -> None:
    path = tmp_path / "study.log"
    before = search(path, config("tune.trials=3")).get_trials()
    with path.open("ab") as stream:
        stream.write(b'{"op_code":5,"worker_id":"x","trial')
    after = search(path, config()).get_trials()
    assert len(after) == 6
    assert after[:3] == before


def test_a_killed_process_leaves_no_lock(tmp_path: Path) -> None:
    path = tmp_path / "study.log"
    with opened(path, config()):
        pass
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:  # holds the claim and the journal for ever
        try:
            store = JournalStore(path)
            with store.claim("any"):
                store.storage._backend._lock.acquire()
                os.write(writing, b"held")
                signal.pause()
        finally:
            os._exit(1)
    os.read(reading, 4)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    began = time.monotonic()
    assert count(search(path, config())).finished == 6
    assert time.monotonic() - began < 15


def test_a_finished_journal_is_put_away_and_taken_up_again(tmp_path: Path) -> None:
    growing, kept = tmp_path / "growing.log", tmp_path / "artifact" / "journal.log"
    kept.parent.mkdir()
    other = JournalStore(growing)
    search(growing, config("tune.trials=2"))
    last = JournalStore(growing)
    keep_journal(last, kept)
    assert growing.exists()  # another worker is still there
    other.close()
    keep_journal(last, kept)
    assert [path.name for path in tmp_path.iterdir()] == ["artifact"]
    fetch_journal(kept, growing, "another study")
    assert not growing.exists()
    fetch_journal(kept, growing, study_name(config()))
    assert count(search(growing, config())).finished == 6


@pytest.mark.parametrize("url", ["postgresql://me:secret@host:port/studies", "postgresql+"])
def test_an_address_that_cannot_be_read_is_reported_without_its_password(
    tmp_path: Path, url: str
) -> None:
    with pytest.raises(PipelineError, match="cannot open the database") as caught:
        open_store(url, tmp_path / "journal.log", 20)
    assert "secret" not in str(caught.value)


def test_a_journal_on_a_full_disk_is_named_and_goes_on_when_there_is_room(tmp_path: Path) -> None:
    whole = trials_table(search(tmp_path / "whole.log", config()))
    path = tmp_path / "full.log"
    with pytest.raises(OSError, match=REFUSAL) as caught, full_disk(5_000):
        search(path, config())
    assert caught.value.filename == str(path)
    again = trials_table(search(path, config()))
    ended = again[again.state == "COMPLETE"].drop(columns="number").reset_index(drop=True)
    wanted = whole.drop(columns="number")
    assert ended[wanted.columns].equals(wanted)


def test_a_trial_that_a_signal_ends_or_that_fails_prints_no_traceback(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    def terminated(trial: Trial) -> float:
        raise KeyboardInterrupt

    def failing(trial: Trial) -> float:
        raise RuntimeError("out of memory\nat line 3")

    with pytest.raises(KeyboardInterrupt):
        search(tmp_path / "a.log", config(), terminated)
    with pytest.raises(PipelineError, match="trials in a row failed"):
        search(tmp_path / "b.log", config("tune.stop.failures=2"), failing)
    assert "Traceback" not in capfd.readouterr().err
