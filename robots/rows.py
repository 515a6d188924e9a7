"""Rows of compiled loops."""

from __future__ import annotations

from robots.compiled import njit


@njit(no_cpython_wrapper=True)
def copy_row(source, target):  # type: ignore[no-untyped-def]
    """Copy the numbers of a row into another one of its length or shorter.

    ``target[:] = source`` does the same, but for it Numba compiles the message about rows of
    different lengths, with strings and all: two seconds where the kernels take twelve.
    """
    for k in range(target.shape[0]):
        target[k] = source[k]
