"""What libraries written in C print to standard output, kept away from it."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

STDOUT, STDERR = 1, 2


@contextmanager
def stdout_elsewhere(shown: bool) -> Iterator[None]:
    """Keep standard output free of what is printed below Python: it carries results and no more.

    Args:
        shown: Whether it goes to standard error, or nowhere.
    """
    sys.stdout.flush()
    kept = os.dup(STDOUT)
    place = os.dup(STDERR) if shown else os.open(os.devnull, os.O_WRONLY)
    try:
        os.dup2(place, STDOUT)
        yield
    finally:
        ctypes.CDLL(None).fflush(None)  # C keeps what goes to a file until its buffer is full
        os.dup2(kept, STDOUT)
        os.close(kept)
        os.close(place)
