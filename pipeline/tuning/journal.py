"""A study in a journal file that the processes of one disk share."""

from __future__ import annotations

import os
import shutil
import socket
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from filelock import FileLock, Timeout
from optuna import Study, Trial
from optuna.storages import BaseStorage, JournalStorage
from optuna.storages.journal import JournalFileBackend
from optuna.trial import FrozenTrial, TrialState

from pipeline.data.files import replacing

WORKER = "worker"  # attribute of a trial: the token of the worker that runs it
POLL_S = 0.005  # between attempts to take the lock of a journal, which is held for milliseconds
RUNNING = (TrialState.RUNNING,)
Release = Callable[[], object]


class KernelLock:
    """The lock of a journal file while it is written.

    Optuna's own lock files outlive a killed process, and the others then wait half a minute. A
    process that dies while it writes leaves half a line, which the next line would be glued to: it
    is cut off here, before anything is appended.

    Args:
        journal: The journal file.
    """

    def __init__(self, journal: Path) -> None:
        self.journal = journal
        self._lock = FileLock(journal.with_suffix(".lock"), poll_interval=POLL_S)

    def acquire(self) -> bool:
        """Wait for the lock and repair the end of the file."""
        self._lock.acquire()
        with self.journal.open("rb+") as stream:
            size = stream.seek(0, os.SEEK_END)
            end = size
            while end > 0:
                stream.seek(end - 1)
                if stream.read(1) == b"\n":
                    break
                end -= 1
            if end < size:
                stream.truncate(end)
        return True

    def release(self) -> None:
        """Give the lock back."""
        self._lock.release()


class JournalStore:
    """A journal file that the processes of one disk share.

    Every worker holds the lock of a file of its own, in the folder of the workers, as long as it
    lives: whoever can take that lock knows that the worker is dead.

    Args:
        path: The journal.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        self.path = path
        self.address = str(path)
        self.storage: BaseStorage = JournalStorage(
            JournalFileBackend(str(path), lock_obj=KernelLock(path))
        )
        self.workers = path.with_suffix(".workers")
        self.workers.mkdir(exist_ok=True)
        self.token = new_token()
        self.alive = FileLock(self.workers / self.token, thread_local=False)
        self.alive.acquire()

    @contextmanager
    def claim(self, study: str) -> Iterator[Release]:
        """See `pipeline.tuning.storage.Store.claim`."""
        with FileLock(self.path.with_suffix(".claim")) as held:
            yield held.release

    def begin(self, trial: Trial) -> None:
        """See `pipeline.tuning.storage.Store.begin`."""
        trial.set_user_attr(WORKER, self.token)

    def abandoned(self, study: Study) -> list[FrozenTrial]:
        """See `pipeline.tuning.storage.Store.abandoned`."""
        running = study.get_trials(deepcopy=False, states=RUNNING)
        return [trial for trial in running if not self._lives(trial.user_attrs.get(WORKER))]

    def others(self) -> bool:
        """Whether another worker is at this journal."""
        tokens = [path.name for path in self.workers.iterdir()] if self.workers.exists() else []
        return any(self._lives(token) for token in tokens if token != self.token)

    def close(self) -> None:
        """See `pipeline.tuning.storage.Store.close`."""
        if self.alive.is_locked:
            (self.workers / self.token).unlink(missing_ok=True)
            self.alive.release()

    def remove(self) -> None:
        """Leave the study and remove the journal and what lies beside it; for the last worker."""
        self.close()
        shutil.rmtree(self.workers)
        for path in (self.path, *(self.path.with_suffix(end) for end in (".lock", ".claim"))):
            path.unlink(missing_ok=True)

    def _lives(self, token: str | None) -> bool:
        if token == self.token:
            return True
        if token is None:
            return False  # killed between asking for a trial and signing it, both within a claim
        path = self.workers / token
        if not path.exists():
            return False
        try:
            with FileLock(path, blocking=False):
                path.unlink(missing_ok=True)
            return False
        except Timeout:
            return True


def fetch_journal(kept: Path, growing: Path, study: str) -> None:
    """Continue a study that was finished and stored, if that is the one.

    Args:
        kept: The journal of a finished study, in its artifact.
        growing: The journal that workers write.
        study: Name of the study.
    """
    if kept.exists() and not growing.exists() and study.encode() in kept.read_bytes():
        growing.parent.mkdir(parents=True, exist_ok=True)
        with replacing(growing) as partial:
            shutil.copyfile(kept, partial)


def keep_journal(store: object, kept: Path) -> None:
    """Put the journal of a finished study into its artifact; a database stays where it is."""
    if not isinstance(store, JournalStore):
        return
    with replacing(kept) as partial:
        shutil.copyfile(store.path, partial)
    if not store.others():
        store.remove()


def new_token() -> str:
    """Return a name for a worker that no other has."""
    return f"{socket.gethostname()}-{os.getpid()}-{uuid.uuid4().hex[:8]}"
