"""The gate for numbers that callers hand in: one way to read them, one kind of complaint."""

from __future__ import annotations

import math
import numbers
import operator
from typing import Any, TypeGuard

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

FLOAT64 = np.dtype(np.float64)
SHOWN = 60  # characters of a wrong value that a message repeats


def as_floats(values: ArrayLike, what: str, error: type[ValueError]) -> Array:
    """Turn numbers of any type and memory layout into the one that compiled kernels know.

    Args:
        values: An array, a tensor, or nested sequences of numbers.
        what: What they are, for the message.
        error: The error to raise.

    Returns:
        A float64 array in C order, aligned and writable; a copy wherever it was not one.

    Raises:
        ValueError: Of the type `error`, if they are not real numbers in a rectangle.
    """
    if is_kernel_array(values):
        return values
    if getattr(values, "requires_grad", False):
        raise error(f"{what}: got a tensor that tracks gradients, which end here; pass .detach()")
    if isinstance(values, np.ma.MaskedArray) and np.ma.is_masked(values):
        raise error(f"{what}: got a masked array with masked values; fill them first")
    if values is None or isinstance(values, str | bytes | dict | set):
        raise error(f"{what}: expected numbers, got {shown(values)}")
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, RuntimeError, OverflowError):
        raise error(f"{what}: expected numbers in a rectangle, got {shown(values)}") from None
    if array.dtype.kind == "O":
        array = _from_objects(array, what, error)
    elif array.dtype.kind not in "fiu":
        raise error(f"{what}: expected real numbers, got values of the type {array.dtype}")
    with np.errstate(over="ignore"):
        return compiled_floats(array)


def compiled_floats(array: ArrayLike) -> Array:
    """Return numbers as the one type and layout that kernels are compiled for.

    To numba a read-only array is of another type, for which a caller would wait seconds.
    """
    if is_kernel_array(array):
        return array
    return np.require(array, np.float64, ["C_CONTIGUOUS", "ALIGNED", "WRITEABLE"])


def is_kernel_array(values: object) -> TypeGuard[Array]:
    """Whether a value is already an array of float64 in C order, aligned and writable.

    Checked without a call of NumPy: one query has microseconds in all.
    """
    return type(values) is np.ndarray and values.dtype is FLOAT64 and values.flags.carray


def _from_objects(array: NDArray[Any], what: str, error: type[ValueError]) -> Array:
    if not all(isinstance(value, numbers.Real) for value in array.flat):
        wrong = next(value for value in array.flat if not isinstance(value, numbers.Real))
        raise error(f"{what}: expected numbers in a rectangle, got {shown(wrong)} among them")
    try:
        return array.astype(np.float64)
    except (TypeError, ValueError, OverflowError):
        raise error(f"{what}: expected numbers that fit 64-bit floats") from None


def as_float(value: object, what: str, error: type[ValueError]) -> float:
    """Turn one real number of any type (no truth value, no text) into a float.

    Raises:
        ValueError: Of the type `error`, if it is something else.
    """
    if isinstance(value, np.ndarray) and value.ndim == 0:
        value = value.item()
    if isinstance(value, bool | np.bool_) or not isinstance(value, numbers.Real):
        raise error(f"{what}: expected a number, got {shown(value)}")
    try:
        return float(value)
    except OverflowError:
        return math.copysign(math.inf, 1.0 if value > 0 else -1.0)  # type: ignore[operator]


def as_int(value: object, what: str, error: type[ValueError]) -> int:
    """Turn one whole number of any integer type into an int.

    Raises:
        ValueError: Of the type `error`, if it is something else.
    """
    if not isinstance(value, bool | np.bool_):
        try:
            return operator.index(value)  # type: ignore[arg-type]
        except TypeError:
            pass
    raise error(f"{what}: expected a whole number, got {shown(value)}")


def shown(value: object) -> str:
    """Return a value as a message repeats it: on one line, and not all of a long one."""
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else text[: SHOWN - 3] + "..."
