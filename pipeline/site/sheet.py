"""A table as a page shows it: cells with addresses, values to sort by, columns to choose from."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import PurePosixPath
from typing import Any

from pipeline.presentation.columns import NOTHING, Cell, Column, absent
from pipeline.presentation.table import Table

LONG, PARAGRAPH = 34, 90  # characters beyond which a text may break, and takes more room
CHOICES = range(2, 31)  # values of a column that can be chosen from
MENUS = 4  # of a table at most
FEW = 8  # rows below which there is nothing to look for
FIRST_MENUS = ("machine", "robot", "suite", "solver", "method", "verdict", "protocol")


@dataclass(frozen=True)
class Head:
    """A heading: of which column, how it is set, and what it sorts by."""

    title: str
    css: str


@dataclass(frozen=True)
class Shown:
    """A cell: its text, what it sorts by, its address and where it leads."""

    text: str
    css: str
    value: str = ""
    id: str = ""
    link: str = ""


@dataclass(frozen=True)
class Line:
    """A row with its address."""

    id: str
    cells: Sequence[Shown]


@dataclass(frozen=True)
class Menu:
    """Values of a column that rows can be chosen by."""

    column: int
    title: str
    options: Sequence[str]


@dataclass(frozen=True)
class View:
    """All that a template needs of a table."""

    table: Table
    groups: Sequence[tuple[str, int]]
    heads: Sequence[Head]
    lines: Sequence[Line]
    menus: Sequence[Menu]
    origin: Sequence[tuple[str, str]]
    searchable: bool
    left_out: int


def view_of(table: Table, most: int | None = None) -> View:
    """Lay out a table, or as many of its first rows as there may be."""
    left_out = 0 if most is None else max(0, len(table.rows) - most)
    if left_out:
        table = replace(table, rows=table.rows[:most])
    texts = table.shown()
    css = [_css(column, i, table, texts) for i, column in enumerate(table.columns)]
    keys = row_keys(table, texts)
    lines = [
        Line(f"{table.name}.{key}", _cells(table, row, text, css, f"{table.name}.{key}"))
        for key, row, text in zip(keys, table.rows, texts, strict=True)
    ]
    grouped = any(group for group, _ in table.groups())
    return View(
        table,
        table.groups() if grouped else [],
        [Head(column.title, kind) for column, kind in zip(table.columns, css, strict=True)],
        lines,
        _menus(table, texts),
        _origin(table),
        len(lines) >= FEW,
        left_out,
    )


def row_keys(table: Table, texts: Sequence[Sequence[str]]) -> list[str]:
    """Name each row by as many of its texts as tell it from the others, and a number where none do.

    The names stay the same when rows are added elsewhere, so that links to numbers keep.
    """
    columns = [i for i in range(len(table.columns)) if _is_text(table, i)]
    keys = ["" for _ in texts]
    for i in columns:
        words = [slug(row[i]) for row in texts]
        keys = ["-".join(filter(None, pair)) for pair in zip(keys, words, strict=True)]
        if len(set(keys)) == len(keys) and all(keys):
            return keys
    seen: dict[str, int] = {}
    for number, key in enumerate(keys):
        seen[key] = seen.get(key, 0) + 1
        keys[number] = "-".join(filter(None, (key, str(seen[key]))))
    return keys


def slug(text: str) -> str:
    """Return a text as part of an address: small letters, digits and hyphens."""
    return re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")[:40]


def _cells(
    table: Table, row: Sequence[Cell], texts: Sequence[str], css: Sequence[str], key: str
) -> list[Shown]:
    shown = []
    for column, cell, text, kind in zip(table.columns, row, texts, css, strict=True):
        link = text if column.link and text != NOTHING else ""
        words = PurePosixPath(text).name if link else text
        number = not isinstance(cell, str) and not absent(cell)
        value = f"{float(cell):.9g}" if number and cell is not None else ""
        shown.append(Shown(words, kind, value, f"{key}.{column.name}" if number else "", link))
    return shown


def _is_text(table: Table, i: int) -> bool:
    return not table.rows or any(isinstance(row[i], str) for row in table.rows)


def _css(column: Column, i: int, table: Table, texts: Sequence[Sequence[str]]) -> str:
    kind = "n" if not _is_text(table, i) or _reads_as_number(i, texts) else "t"
    longest = max((len(row[i]) for row in texts), default=0)
    if kind == "t" and longest > LONG:
        kind += " long para" if longest > PARAGRAPH else " long"
    starts = i > 0 and column.group != table.columns[i - 1].group
    return f"{kind} start" if starts else kind


def _reads_as_number(i: int, texts: Sequence[Sequence[str]]) -> bool:
    """Whether all texts of a column are numbers: published ones stand as the paper wrote them."""
    return all(re.fullmatch(r"(< )?[+−-]?[\d.,]+( %)?|–", row[i]) for row in texts)


def _menus(table: Table, texts: Sequence[Sequence[str]]) -> list[Menu]:
    if len(texts) < FEW:
        return []
    found = []
    for i, column in enumerate(table.columns):
        options = list(dict.fromkeys(row[i] for row in texts))
        usual = len(options) in CHOICES and len(options) * 2 <= len(texts)
        if _is_text(table, i) and usual and max(map(len, options)) <= LONG:
            title = " ".join(filter(None, (column.group, column.title)))
            rank = FIRST_MENUS.index(column.name) if column.name in FIRST_MENUS else MENUS + i
            found.append((rank, Menu(i, title.lower(), options)))
    kept = sorted(found, key=lambda each: each[0])[:MENUS]
    return [menu for _, menu in sorted(kept, key=lambda each: each[1].column)]


def _origin(table: Table) -> list[tuple[str, str]]:
    facts: dict[str, Any] = table.origin.facts() if table.origin else {}
    return [(name, text) for name, text in facts.items() if text]
