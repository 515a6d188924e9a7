"""Tables that are committed, as they stand: title, caption and origin come from beside them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import pandas as pd

from pipeline.data.files import read_json
from pipeline.presentation.columns import Column, plain
from pipeline.presentation.origin import Origin, older
from pipeline.presentation.table import ORIGINS, Table

TITLED = re.compile(r"\*\*(.+?)\.\*\* ?(.*)")
DIGITS = 4
UNITS = {"mm", "deg", "us", "ms", "s", "rad", "m", "percent", "ns"}
MANY = 40  # rows beyond which a committed table is folded
MOST = 400  # rows of one on a page; raw rows of thousands of trials would take megabytes


def committed_table(path: Path, prefix: str) -> Table:
    """Read a committed CSV as a table.

    Args:
        path: The CSV; a Markdown file of the same name may say what it is.
        prefix: Of its name on the pages, where tables of a run may have the same.
    """
    rows = pd.read_csv(path)
    title, caption = described(path.with_suffix(".md"))
    columns = [_column(str(name), rows[name]) for name in rows]
    table = Table.of(
        rows.astype(object).where(rows.notna(), None),
        columns,
        name=f"{prefix}_{path.stem}",
        title=title or plain(path.stem).capitalize(),
        caption=caption,
    )
    table.origin = _origin(path)
    return table


def described(path: Path) -> tuple[str, str]:
    """Return title and caption from a Markdown file of a table; empty where it has none."""
    if not path.exists():
        return "", ""
    text = re.sub(r"<!--.*?-->", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
    paragraphs = [" ".join(part.split()) for part in re.split(r"\n\s*\n", text.strip())]
    title = ""
    if paragraphs and paragraphs[0].startswith("# "):
        title = paragraphs.pop(0).removeprefix("# ")
    first = paragraphs[0] if paragraphs else ""
    if titled := TITLED.fullmatch(first):
        return titled[1], titled[2]
    return title, "" if first.startswith("|") else first


def pictures_beside(folder: Path, stems: Sequence[str]) -> dict[str, list[Path]]:
    """Return the pictures of a folder by the table that each belongs to.

    That is the one whose name it begins with, the longest of several; those of none are under "".
    """
    found: dict[str, list[Path]] = {}
    for path in sorted(folder.glob("*.png")):
        owners = [stem for stem in stems if path.stem.startswith(stem)]
        found.setdefault(max(owners, key=len, default=""), []).append(path)
    return found


def _column(name: str, values: pd.Series) -> Column:
    title = plain(name)
    head, _, unit = title.rpartition(" ")
    if head and unit in UNITS:
        title = f"{head} [{'%' if unit == 'percent' else unit}]"
    if pd.api.types.is_bool_dtype(values) or not pd.api.types.is_numeric_dtype(values):
        return Column(name, title, convert=str)
    whole = pd.api.types.is_integer_dtype(values)
    return Column(name, title, convert=int if whole else float, digits=None if whole else DIGITS)


def _origin(path: Path) -> Origin:
    beside = path.parent / ORIGINS
    facts = (read_json(beside) if beside.exists() else {}).get(path.stem)
    if facts is None:
        return older("not recorded")
    return Origin(**{field.name: str(facts.get(field.name, "")) for field in fields(Origin)})
