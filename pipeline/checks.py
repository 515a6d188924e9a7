"""Range checks of configuration values: each raises `ValueError` with key, value and range."""

from __future__ import annotations

import math
from collections.abc import Iterable

COUNTS = {2: "two", 3: "three", 4: "four"}


def positive(key: str, value: float) -> None:
    """Refuse zero, negative and non-finite numbers; a value still missing (``???``) passes."""
    if _number(value) and not (math.isfinite(value) and value > 0):
        raise ValueError(f"{key} must be greater than 0, got {value}")


def positive_all(key: str, values: Iterable[float]) -> None:
    """Refuse an empty list and any number in it that is not positive."""
    if isinstance(values, str):
        return
    items = list(values)
    if not items:
        raise ValueError(f"{key} must not be empty")
    for value in items:
        positive(key, value)


def at_least(key: str, value: float, low: float) -> None:
    """Refuse numbers below ``low`` and non-finite ones."""
    if _number(value) and not (math.isfinite(value) and value >= low):
        raise ValueError(f"{key} must be at least {low}, got {value}")


def within(key: str, value: float, low: float, high: float) -> None:
    """Refuse numbers outside ``[low, high]``."""
    if _number(value) and not low <= value <= high:
        raise ValueError(f"{key} must lie between {low} and {high}, got {value}")


def ordered(key: str, low: float, high: float) -> None:
    """Refuse an interval whose ends are swapped."""
    if _number(low) and _number(high) and low > high:
        raise ValueError(f"{key}: low {low} is above high {high}")


def interval(key: str, ends: Iterable[float]) -> None:
    """Refuse anything but two ends, the lower one first; a value still missing passes."""
    if isinstance(ends, str):
        return
    numbers(key, ends, 2)
    ordered(key, *ends)


def numbers(key: str, values: Iterable[float], count: int) -> None:
    """Refuse anything but a list of ``count`` numbers; a value still missing passes."""
    if isinstance(values, str):
        return
    items = list(values)
    if len(items) != count:
        raise ValueError(f"{key} must be {COUNTS[count]} numbers, got {items}")


def one_of(key: str, value: str, valid: Iterable[str]) -> None:
    """Refuse a name that is not among ``valid``."""
    names = tuple(valid)
    if value != "???" and value not in names:
        raise ValueError(f"{key} must be one of {', '.join(names)}, got '{value}'")


def _number(value: object) -> bool:
    return isinstance(value, int | float)
