"""The monotonic clock and counter-based random numbers for compiled code."""

from __future__ import annotations

import time

import numpy as np
from numba import types

from robots.compiled import njit

MONOTONIC = time.CLOCK_MONOTONIC
# int clock_gettime(clockid_t, struct timespec *): resolved by name, so that callers can be cached.
_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.uintp))

GOLDEN = np.uint64(0x9E3779B97F4A7C15)
MIX_1 = np.uint64(0xBF58476D1CE4E5B9)
MIX_2 = np.uint64(0x94D049BB133111EB)
TO_UNIT = 2.0**-53
UNSIGNED = np.uint64(0x7FFFFFFFFFFFFFFF)  # all bits of a float64 but its sign


@njit()
def now_ns(timespec):  # type: ignore[no-untyped-def]
    """Monotonic time in ns, the same clock as `time.monotonic_ns`.

    Args:
        timespec: (2,) int64 scratch that receives seconds and nanoseconds.
    """
    _clock_gettime(MONOTONIC, timespec.ctypes.data)
    return timespec[0] * 1_000_000_000 + timespec[1]


@njit(no_cpython_wrapper=True, _nrt=False)
def mix(value):  # type: ignore[no-untyped-def]
    """Scramble 64 bits: the output function of SplitMix64 (Steele, Lea and Flood, 2014)."""
    value = (value ^ (value >> np.uint64(30))) * MIX_1
    value = (value ^ (value >> np.uint64(27))) * MIX_2
    return value ^ (value >> np.uint64(31))


@njit(_nrt=False)
def uniform(key, counter):  # type: ignore[no-untyped-def]
    """Return the `counter`-th uniform number in [0, 1) of the stream `key` (both uint64)."""
    bits = mix(key + GOLDEN * (np.uint64(counter) + np.uint64(1)))
    return (bits >> np.uint64(11)) * TO_UNIT


@njit(_nrt=False)
def pose_key(pose):  # type: ignore[no-untyped-def]
    """Return a stream key that depends on a pose (7,) alone, not on its quaternion's sign."""
    bits = pose.view(np.uint64)
    key = np.uint64(0)
    for i in range(7):
        number = bits[i] if i < 3 else bits[i] & UNSIGNED
        key = mix(key ^ number) + GOLDEN
    return key
