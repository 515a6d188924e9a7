"""A disk that takes no more: files may grow to some bytes, as on one that is almost full."""

from __future__ import annotations

import resource
from collections.abc import Iterator
from contextlib import contextmanager

REFUSAL = "File too large"  # what the system says, as "No space left on device" of a full disk


@contextmanager
def full_disk(room: int) -> Iterator[None]:
    """Let no file of this process grow beyond ``room`` bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
