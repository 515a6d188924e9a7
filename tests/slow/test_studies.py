"""A study in PostgreSQL: four workers, two of them killed, and two machines that start at once.

    pytest -m slow tests/slow/test_studies.py

The server is started for the tests from Debian's package postgresql, on a socket of its own.
"""

from __future__ import annotations

import os
import pwd
import random
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import optuna
import pytest
from optuna.trial import FrozenTrial

from pipeline.config import compose
from pipeline.stages.running import run_stage
from tests import tune_runs
from tests.toy import TOY
from tests.tune_runs import check_total, ended, kill_a_worker, start

pytestmark = pytest.mark.slow
TOTAL = 14


def binary(name: str) -> str:
    """Debian keeps the programs of the server out of the path."""
    found = shutil.which(name) or next(
        (str(path) for path in sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"))), None
    )
    if found is None:
        pytest.skip(f"no {name}: install Debian's package postgresql")
    return found


@contextmanager
def running_server() -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """URL of an empty database, and the server that holds it."""
    pytest.importorskip("psycopg", reason="the extra cluster is not installed")
    commands = [binary(name) for name in ("initdb", "postgres", "pg_isready", "createdb")]
    initdb, postgres, pg_isready, createdb = commands
    # The server refuses to run as root, and a folder of pytest's belongs to the user alone.
    user = None if os.geteuid() else "postgres"
    folder = Path(tempfile.mkdtemp(prefix="studies"))
    name = pwd.getpwuid(os.geteuid()).pw_name if user is None else user
    shutil.chown(folder, name)
    folder.chmod(0o755)
    data = folder / "data"
    quiet = {"user": user, "check": True, "cwd": folder, "stdout": subprocess.DEVNULL}
    subprocess.run([initdb, "-D", data, "-A", "trust", "--no-sync"], **quiet)
    options = ["-k", str(folder), "-c", "listen_addresses=", "-c", "fsync=off"]
    with subprocess.Popen(
        [postgres, "-D", data, *options], user=user, cwd=folder, stderr=subprocess.DEVNULL
    ) as running:
        try:
            ready = [pg_isready, "-q", "-h", folder, "-d", "postgres"]
            for _ in range(100):
                if subprocess.run(ready).returncode == 0:
                    break
                subprocess.run(["sleep", "0.1"], check=True)
            subprocess.run([createdb, "-h", folder, "studies"], **quiet)
            yield f"postgresql://{name}@/studies?host={folder}", running
        finally:
            running.send_signal(signal.SIGINT)  # what the server calls a fast shutdown
            running.wait(30)
            shutil.rmtree(folder, ignore_errors=True)


@pytest.fixture(scope="module")
def server() -> Iterator[str]:
    """URL of a database of a server that lives as long as these tests."""
    with running_server() as (url, _):
        yield url


def of_study(url: str, name: str) -> list[FrozenTrial]:
    storage = optuna.storages.RDBStorage(url)
    return optuna.load_study(study_name=name, storage=storage).get_trials()


def results(folder: Path, seed: int = 0) -> list[str]:
    overrides = [f"results_dir={folder}", f"seed={seed}"]
    run_stage("dataset", compose([*TOY, *overrides]))
    return overrides


def test_four_workers_of_a_server_two_of_them_killed(server: str, tmp_path: Path) -> None:
    keys = [f"tune.storage='{server}'", "tune.heartbeat_s=4", f"tune.trials={TOTAL}"]
    search = start(*results(tmp_path), *keys, "tune.workers=4")
    generator = random.Random()
    storage = optuna.storages.RDBStorage(server)

    def look() -> list[FrozenTrial]:
        names = optuna.get_all_study_names(storage)
        return of_study(server, names[0]) if names else []

    dead: list[int] = []
    for done in (2, 6):
        dead.append(kill_a_worker(look, generator, done, spared=search.pid, dead=dead))
    log = ended(search)
    assert log.count("worker process died") == 2, log
    assert "optuna-dashboard 'postgresql://" in log
    check_total(tmp_path, TOTAL, cut_off=2)


def test_two_machines_start_one_study_at_the_same_moment(server: str, tmp_path: Path) -> None:
    """Each with a results folder of its own: nothing but the server is shared."""
    keys = [f"tune.storage='{server}'", "tune.trials=8"]
    both = [start(*results(tmp_path / name, seed=1), *keys) for name in ("a", "b")]
    for search in both:
        ended(search)
    tables = [check_total(tmp_path / name, 8, cut_off=0) for name in ("a", "b")]
    assert tables[0].equals(tables[1])


def test_a_server_that_goes_away_is_reported_in_one_sentence(tmp_path: Path) -> None:
    with running_server() as (url, process):
        storage = optuna.storages.RDBStorage(url)
        search = start(*results(tmp_path, seed=2), f"tune.storage='{url}'", "tune.trials=500")
        deadline = time.monotonic() + tune_runs.DEADLINE_S
        while time.monotonic() < deadline:
            names = optuna.get_all_study_names(storage)
            if names and sum(trial.state.is_finished() for trial in of_study(url, names[0])) >= 2:
                break
            time.sleep(0.2)
        storage.remove_session()
        process.send_signal(signal.SIGINT)
        _, log = search.communicate(timeout=tune_runs.DEADLINE_S)
    text = log.decode(errors="replace")
    assert search.returncode == 2, text
    assert "no longer answers" in text
    assert "Traceback" not in text
