"""Memory that a training gets back every step."""

from __future__ import annotations

import ctypes
import platform
from functools import cache

# Of glibc's malloc.h. The second is the largest that mallopt takes on 64 bits.
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD = -1, -3
TRIM, LARGEST = 2**31 - 1, 32 * 2**20


@cache
def keep_freed_memory() -> bool:
    """Keep what tensors give back in the process, and return whether that could be arranged.

    The gradients of a large network are freed and allocated with every step. By default glibc hands
    them back to the kernel each time, which fills them with zeros page by page when they are used
    again: with 29 million weights a quarter of a step. Other C libraries are left as they are.
    """
    if platform.libc_ver()[0] != "glibc":
        return False
    library = ctypes.CDLL(None)
    trimmed = library.mallopt(M_TRIM_THRESHOLD, TRIM)
    return bool(trimmed and library.mallopt(M_MMAP_THRESHOLD, LARGEST))
