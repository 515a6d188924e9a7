"""Where a study is kept, and how its workers keep out of each other's way.

Optuna stores trials; for a total to be exact, three conditions must hold besides. One worker at
a time begins a trial (`Store.claim`). Trials that nobody runs any more are known as such
(`Store.abandoned`). And a worker that is killed (SIGKILL, out of memory) leaves nothing locked:
every lock here is the kernel's or the server's, which drop it with its process.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path
from typing import Protocol

from optuna import Study, Trial
from optuna.exceptions import ExperimentalWarning, StorageInternalError
from optuna.storages import BaseStorage, fail_stale_trials
from optuna.trial import FrozenTrial
from sqlalchemy.exc import SQLAlchemyError

from pipeline.errors import PipelineError
from pipeline.tuning.journal import RUNNING, WORKER, JournalStore, Release, new_token

MISSED = 3  # heartbeats, after which a worker counts as dead
SCHEMA = "optuna schema"  # what is locked while the tables are made
STORAGE_ERRORS = (SQLAlchemyError, StorageInternalError)  # what a server that has gone raises


class Store(Protocol):
    """The storage of one study as one worker sees it."""

    storage: BaseStorage
    address: str  # what optuna-dashboard opens

    @contextmanager
    def claim(self, study: str) -> Iterator[Release]:
        """Let no other worker of a study begin a trial until the release, or the end."""

    def begin(self, trial: Trial) -> None:
        """Note on a trial that this worker runs it; within the claim."""

    def abandoned(self, study: Study) -> list[FrozenTrial]:
        """Return the running trials whose worker is dead; within the claim."""

    def close(self) -> None:
        """Leave the study: trials of this worker that still run are abandoned."""


def open_store(storage: str, journal: Path, heartbeat_s: int) -> Store:
    """Open the storage that ``tune.storage`` names.

    Args:
        storage: ``journal`` or the URL of a PostgreSQL database.
        journal: The journal file, where that is the storage.
        heartbeat_s: Seconds between signs of life in PostgreSQL.
    """
    if storage == "journal":
        return JournalStore(journal)
    return PostgresStore(storage, heartbeat_s)


@contextmanager
def storage_errors_named(store: Store) -> Iterator[None]:
    """Name in one sentence a server that goes away in the middle of a study.

    Raises:
        PipelineError: The storage no longer answers.
    """
    try:
        yield
    except STORAGE_ERRORS as error:
        raise PipelineError(
            f"tune.storage: {store.address} no longer answers ({_why(error)}); trials that had "
            "ended are kept there, and the same command goes on with them"
        ) from error


class PostgresStore:
    """A PostgreSQL database that many machines share; Optuna's heartbeats show who is alive.

    Args:
        url: Its address.
        heartbeat_s: Seconds between signs of life.

    Raises:
        PipelineError: The packages are missing, or there is no such database.
    """

    def __init__(self, url: str, heartbeat_s: int) -> None:
        try:
            from optuna.storages import RDBStorage
            from sqlalchemy.engine import make_url

            self.url = url
            self.address = "the database"  # until it is known what of the URL is a password
            self.address = make_url(url).render_as_string(hide_password=True)
            warnings.filterwarnings("ignore", category=ExperimentalWarning)
            # Two first workers that make the tables at once would fail each other.
            with self.claim(SCHEMA):
                self.storage: BaseStorage = RDBStorage(
                    url,
                    heartbeat_interval=heartbeat_s,
                    grace_period=MISSED * heartbeat_s,
                    engine_kwargs={"pool_pre_ping": True},
                )
        except ImportError as error:
            raise PipelineError(
                f"tune.storage={url.split(':')[0]} needs the extra cluster: "
                f"pip install '.[cluster]' ({error})"
            ) from error
        except (*STORAGE_ERRORS, ValueError) as error:  # the latter of a port that is no number
            raise PipelineError(
                f"tune.storage: cannot open {self.address}: {_why(error)}"
            ) from error
        self.token = new_token()

    @contextmanager
    def claim(self, study: str) -> Iterator[Release]:
        """See `Store.claim`; the server drops the lock with the connection."""
        from sqlalchemy import create_engine, text
        from sqlalchemy.pool import NullPool

        key = int.from_bytes(sha256(study.encode()).digest()[:8], "big", signed=True)
        engine = create_engine(self.url, poolclass=NullPool, isolation_level="AUTOCOMMIT")
        with engine.connect() as connection:
            connection.execute(text("SELECT pg_advisory_lock(:key)"), {"key": key})
            yield connection.close

    def begin(self, trial: Trial) -> None:
        """See `Store.begin`; the first heartbeat comes before the signature."""
        self.storage.record_heartbeat(trial._trial_id)
        trial.set_user_attr(WORKER, self.token)

    def abandoned(self, study: Study) -> list[FrozenTrial]:
        """See `Store.abandoned`; those without a heartbeat in time are failed by Optuna."""
        fail_stale_trials(study)
        running = study.get_trials(deepcopy=False, states=RUNNING)
        return [trial for trial in running if WORKER not in trial.user_attrs]

    def close(self) -> None:
        """See `Store.close`."""
        self.storage.remove_session()


def _why(error: BaseException) -> str:
    """Return the first line of the innermost cause: Optuna's own says only that it failed."""
    while error.__cause__ is not None:
        error = error.__cause__
    return (str(error).strip().splitlines() or [type(error).__name__])[0]
