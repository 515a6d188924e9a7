"""What times were measured on: a fingerprint of the machine, and the process pinned to cores."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numba
import torch

from pipeline.engine.cores import usable_cores
from pipeline.provenance import machine, versions


def allowed_threads(threads: int, is_pinned: bool) -> int:
    """Return how many cores an evaluation may use: ``threads`` if pinned, else all usable ones."""
    return threads if is_pinned else usable_cores()


def machine_fingerprint(threads: int) -> dict[str, Any]:
    """Describe what a measured time depends on.

    Args:
        threads: Cores that the measured code was allowed.

    Returns:
        Processor, cores, system, accelerator, versions of Python and packages, threads.
    """
    accelerator = torch.cuda.get_device_name(0) if torch.cuda.is_available() else "none"
    return {**machine(), "accelerator": accelerator, "versions": versions(), "threads": threads}


def fingerprint_hash(fingerprint: dict[str, Any]) -> str:
    """Return eight hexadecimal digits that tell one fingerprint from another."""
    text = json.dumps(fingerprint, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:8]


@contextmanager
def pinned(threads: int, cores: bool = True, first: int = 0) -> Iterator[None]:
    """Keep this process on ``threads`` cores, torch and Numba on as many threads; then undo it.

    Does what the system allows: where processes cannot be pinned, only the thread pools are held
    back.

    Args:
        threads: Cores, and threads of torch and Numba.
        cores: False holds back the thread pools only; threads of a solver's own roam.
        first: Which of the usable cores is the first, counted round.
    """
    before_torch, before_numba = torch.get_num_threads(), numba.get_num_threads()
    can_pin = cores and hasattr(os, "sched_setaffinity")
    before_cores = os.sched_getaffinity(0) if can_pin else set()
    try:
        torch.set_num_threads(threads)
        numba.set_num_threads(min(threads, numba.config.NUMBA_NUM_THREADS))
        if before_cores:
            usable = sorted(before_cores)
            chosen = {usable[(first + k) % len(usable)] for k in range(threads)}
            os.sched_setaffinity(0, chosen)
        yield
    finally:
        torch.set_num_threads(before_torch)
        numba.set_num_threads(before_numba)
        if before_cores:
            os.sched_setaffinity(0, before_cores)
