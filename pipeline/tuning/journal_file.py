"""The file of a journal: a line a change of the study, each with its checksum."""

from __future__ import annotations

import json
import os
import zlib
from collections.abc import Generator
from pathlib import Path
from typing import Any

from filelock import FileLock
from optuna.storages.journal import JournalFileBackend

from pipeline.data.files import naming
from pipeline.errors import PipelineError

POLL_S = 0.005  # between attempts to take the lock of a journal, which is held for milliseconds
CHECKSUM = "crc32"  # key of a line; Optuna and its dashboard look at the others only


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


class JournalFile(JournalFileBackend):
    """Optuna's journal file with a checksum in each line.

    Args:
        path: The journal.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(str(path), lock_obj=KernelLock(path))
        self.path = path

    def append_logs(self, logs: list[dict[str, Any]]) -> None:
        """Append lines; an error of the disk names the file."""
        with naming(self.path):
            super().append_logs([{**log, CHECKSUM: _checksum(log)} for log in logs])

    def read_logs(self, log_number_from: int) -> Generator[dict[str, Any], None, None]:
        """Read the lines from a number on.

        Raises:
            PipelineError: A line was damaged since the journal was opened.
        """
        try:
            for log in super().read_logs(log_number_from):
                if not _is_whole(log):
                    raise ValueError("a checksum is wrong")
                yield {key: value for key, value in log.items() if key != CHECKSUM}
        except ValueError as error:
            raise PipelineError(
                f"{self.path} was damaged while the search ran ({error}); the same command goes "
                "on with what is left of it"
            ) from error


def whole_bytes(path: Path) -> int:
    """Return how many bytes of a journal lie before its first damaged line, its size if none is."""
    end = 0
    with path.open("rb") as stream:
        for line in stream:
            try:
                log = json.loads(line)
            except ValueError:
                break
            if not line.endswith(b"\n") or not isinstance(log, dict) or not _is_whole(log):
                break
            end += len(line)
    return end


def _is_whole(log: dict[str, Any]) -> bool:
    """Whether a line is as it was written; those of earlier versions have no checksum."""
    others = {key: value for key, value in log.items() if key != CHECKSUM}
    return CHECKSUM not in log or log[CHECKSUM] == _checksum(others)


def _checksum(log: dict[str, Any]) -> int:
    """Checksum of a line as JSON gives it back."""
    return zlib.crc32(json.dumps(json.loads(json.dumps(log)), sort_keys=True).encode())
