"""Compiled functions called without Numba's dispatcher, for calls of microseconds."""

from __future__ import annotations

from typing import Any, TypeGuard

import numpy as np
from numba import typeof
from numpy.typing import NDArray

from robots.arguments import is_kernel_array


class BoundKernel:
    """One specialisation of a compiled function, with its last arguments bound.

    Numba's dispatcher looks at the type of every array of every argument anew, which takes longer
    than half a descent; the entry of the one specialisation that is needed does not. It does not
    notice either when it is handed something else: check arrays by `is_plain`.

    Args:
        function: The compiled function.
        examples: Its first arguments, of the types that it will be called with.
        bound: Its other arguments.
    """

    def __init__(self, function: Any, examples: tuple[Any, ...], bound: tuple[Any, ...]) -> None:
        self._entry = function.compile(tuple(typeof(value) for value in (*examples, *bound)))
        self._bound = bound

    def __call__(self, *arguments: Any) -> Any:
        """Call the function with its first arguments."""
        return self._entry(*arguments, *self._bound)


def is_plain(values: object, shape: tuple[int, ...]) -> TypeGuard[NDArray[np.float64]]:
    """Whether a value is an array of float64 in C order, aligned and writable, of a shape."""
    return is_kernel_array(values) and values.shape == shape
