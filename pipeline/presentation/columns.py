"""Columns of a table: each is named once, with its heading, its format and where its cells are."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

from pipeline.presentation.naming import robot_title, solver_title

Cell = str | float | int | None
Source = str | Callable[[Any], Any]
MOST_DECIMALS, SMALLEST = 4, 1e-4  # mm, deg and ms: finer is noise to a reader; the CSV has it
NOTHING = "–"  # what is not there


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes:
        name: Name in the CSV, with its unit.
        title: Heading for people.
        group: Heading above, shared with neighbours.
        source: Where a cell comes from: a key or attribute of what a row is made of, or a function
            of it; None for the column's own name.
        convert: Applied to what is there; None leaves it as it is.
        digits: Significant digits for numbers; None for text.
        signed: Show a plus sign too: a difference.
        percent: Numbers are shares, shown in per cent with that many decimals.
        decimals: Decimals instead of significant digits.
        link: Text is the path of a file, seen from the report; HTML links to it.
    """

    name: str
    title: str
    group: str = ""
    source: Source | None = None
    convert: Callable[[Any], Cell] | None = None
    digits: int | None = None
    signed: bool = False
    percent: int | None = None
    decimals: int | None = None
    link: bool = False

    def cell(self, line: Any) -> Cell:
        """Return the cell of a line.

        Args:
            line: What a row is made of: a mapping, or any object with attributes.

        Raises:
            KeyError: A mapping lacks the source.
            AttributeError: An object lacks it.
        """
        value = self._value(line)
        return value if self.convert is None or absent(value) else self.convert(value)

    def show(self, value: Cell) -> str:
        """Format a cell for people; what is not there is a dash."""
        if value is None or absent(value):
            return NOTHING
        if isinstance(value, str | bool):
            return str(value)
        sign = "+" if self.signed else ""
        if self.percent is not None:
            return f"{value * 100:{sign}.{self.percent}f}".replace("-", "−")
        if self.decimals is not None:
            return f"{value:{sign}.{self.decimals}f}".replace("-", "−")
        if self.digits is None:
            return f"{value:,}" if isinstance(value, int) else f"{value:g}"
        return significant(float(value), self.digits, self.signed)

    def _value(self, line: Any) -> Any:
        source = self.name if self.source is None else self.source
        if callable(source):
            return source(line)
        return line[source] if isinstance(line, Mapping) else getattr(line, source)


def text(
    name: str,
    title: str,
    source: Source | None = None,
    *,
    convert: Callable[[Any], Cell] | None = None,
    link: bool = False,
) -> Column:
    """Return a column of text, or of what is shown as it is."""
    return Column(name, title, source=source, convert=convert, link=link)


def count(name: str, title: str, source: Source | None = None) -> Column:
    """Return a column of whole numbers."""
    return Column(name, title, source=source, convert=int)


def number(
    name: str,
    title: str,
    source: Source | None = None,
    digits: int | None = 3,
    *,
    decimals: int | None = None,
    signed: bool = False,
) -> Column:
    """Return a column of numbers with significant digits, or with decimals."""
    return Column(
        name,
        title,
        source=source,
        convert=float,
        digits=digits,
        decimals=decimals,
        signed=signed,
    )


def share(
    name: str,
    title: str,
    source: Source | None = None,
    decimals: int = 1,
    *,
    signed: bool = False,
) -> Column:
    """Return a column of shares, shown in per cent."""
    return Column(name, title, source=source, convert=float, percent=decimals, signed=signed)


def p_value(name: str, source: Source | None = None) -> Column:
    """Return a column of p-values; below 0.001 they are shown as that."""
    return text(name, "p", source, convert=lambda p: "< 0.001" if p < 0.001 else f"{p:.3f}")


ROBOT = text("robot", "Robot", convert=robot_title)
SOLVER = text("solver", "Solver", convert=solver_title)


def under(group: str, *columns: Column) -> tuple[Column, ...]:
    """Return columns under a shared heading."""
    return tuple(replace(column, group=group) for column in columns)


def plain(name: object) -> str:
    """Return a name of an object or of a study without underscores."""
    return str(name).replace("_", " ")


def absent(cell: Any) -> bool:
    """Whether there is nothing in a cell."""
    return cell is None or (isinstance(cell, float) and math.isnan(cell))


def significant(value: float, digits: int, signed: bool = False) -> str:
    """Format a number with so many significant digits, but at most four decimals."""
    if not math.isfinite(value):
        return str(value)
    sign = "+" if signed else ""
    if value == 0:
        return f"{0:{sign}.0f}"
    if abs(value) < SMALLEST / 2:
        return f"< {SMALLEST:g}" if value > 0 else f"> −{SMALLEST:g}"
    magnitude = math.floor(math.log10(abs(value)))
    decimals = min(max(digits - 1 - magnitude, 0), MOST_DECIMALS)
    return f"{value:{sign},.{decimals}f}".replace("-", "−")
