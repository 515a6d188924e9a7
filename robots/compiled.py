"""How functions are compiled here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba


def njit(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """`numba.njit` with what all functions of this project have in common.

    They are kept on disk, see `robots.compiled_cache`, and go without the entry for C that numba
    makes for each and that nobody calls, but that takes time to compile.

    Args:
        **options: Others of `numba.njit`.
    """
    return numba.njit(cache=True, no_cfunc_wrapper=True, **options)
