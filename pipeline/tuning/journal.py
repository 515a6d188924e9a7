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
from optuna.trial import FrozenTrial, TrialState

from pipeline.data.files import replacing
from pipeline.errors import PipelineError
from pipeline.progress import LOGGER
from pipeline.tuning.journal_file import JournalFile, KernelLock, whole_bytes

WORKER = "worker"  # attribute of a trial: the token of the worker that runs it
RUNNING = (TrialState.RUNNING,)
Release = Callable[[], object]


class JournalStore:
    """A journal file that the processes of one disk share.

    Every worker holds the lock of a file of its own, in the folder of the workers, as long as it
    lives: whoever can take that lock knows that the worker is dead.

    Args:
        path: The journal.

    Raises:
        PipelineError: The journal is damaged, and others are at it.
    """

    def __init__(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
        self.path = path
        self.address = str(path)
        self.workers = path.with_suffix(".workers")
        self.workers.mkdir(exist_ok=True)
        self.token = new_token()
        self._cut_damage()
        self.storage: BaseStorage = JournalStorage(JournalFile(path))
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

    def _cut_damage(self) -> None:
        """Cut a damaged journal off where its damage begins: what is lost is searched again."""
        lock = KernelLock(self.path)
        lock.acquire()
        try:
            whole = whole_bytes(self.path)
            if whole == self.path.stat().st_size:
                return
            if self.others():
                raise PipelineError(
                    f"{self.path} is damaged from byte {whole} on, and other workers are at it: "
                    "stop them and run the same command again"
                )
            LOGGER.warning(
                "%s is damaged from byte %d on: what follows is searched again", self.path, whole
            )
            os.truncate(self.path, whole)
        finally:
            lock.release()

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
