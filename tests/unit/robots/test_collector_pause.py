"""The collector of garbage waits while kernels are compiled, and only then."""

from __future__ import annotations

import gc
from collections.abc import Iterator

import numpy as np
import pytest
from numba import njit
from numba.core.errors import TypingError
from numba.extending import overload

import robots  # noqa: F401 - has the pause set up

SEEN: list[bool] = []


def look() -> None:
    """Say whether the collector runs, while this is compiled."""


@overload(look)
def _look():  # type: ignore[no-untyped-def]
    SEEN.append(gc.isenabled())
    return lambda: None


@pytest.fixture(autouse=True)
def collecting() -> Iterator[None]:
    SEEN.clear()
    gc.enable()
    yield
    gc.enable()


def test_it_waits_for_the_outermost_function_and_goes_on() -> None:
    inner = njit(lambda x: x + 1)

    @njit
    def outer(x):  # type: ignore[no-untyped-def]
        y = inner(x)
        look()
        return y

    assert outer(np.float64(1.0)) == 2.0
    assert SEEN
    assert not any(SEEN)
    assert gc.isenabled()


def test_it_goes_on_after_a_function_that_cannot_be_compiled() -> None:
    with pytest.raises(TypingError):
        njit(lambda x: x.nothing)(np.float64(1.0))
    assert gc.isenabled()


def test_who_has_stopped_it_finds_it_stopped() -> None:
    gc.disable()
    njit(lambda x: x + 2)(np.float64(1.0))
    assert not gc.isenabled()
