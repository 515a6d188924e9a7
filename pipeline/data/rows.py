"""Rows of an experiment kept as JSON lines while it runs, so that a killed one continues."""

from __future__ import annotations

import json
import zlib
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.data.files import naming, write_text

Row = dict[str, Any]


class RowCheckpoint:
    """Finished rows by key, in a file that grows by one line a row.

    Args:
        path: The file; it is made with the first row. Its name should say everything that the rows
            depend on, for example by a digest: what is in it is taken as it is.
        key: Columns that tell a row from all others.
    """

    def __init__(self, path: Path, key: Iterable[str]) -> None:
        self.path = path
        self.key = tuple(key)
        self._rows = {self._key(row): row for row in _whole_lines(path)}

    def get(self, *key: object) -> Row | None:
        """Return the row of a key, or None if it was not finished yet."""
        return self._rows.get(key)

    def put(self, row: Row) -> None:
        """Keep a finished row; its values are plain (numbers, text, lists of them)."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        with naming(self.path), self.path.open("a", encoding="utf-8") as stream:
            stream.write(_line(row))
        self._rows[self._key(row)] = row

    def clear(self) -> None:
        """Remove the file; to be called when the rows are safely written elsewhere."""
        self.path.unlink(missing_ok=True)

    def _key(self, row: Row) -> tuple[object, ...]:
        return tuple(row[name] for name in self.key)


class Resumable(ABC):
    """Work in units that do not need each other, whose rows are kept as they are finished."""

    @abstractmethod
    def units(self) -> dict[Any, list[tuple[object, ...]]]:
        """Return all units in order, each with the keys of the rows that it gives."""

    @abstractmethod
    def unit(self, unit: Any) -> list[Row]:
        """Run one unit and return its raw rows."""

    def pending(self, kept: RowCheckpoint) -> list[Any]:
        """Return the units of which a row is missing."""
        units = self.units().items()
        return [unit for unit, keys in units if any(kept.get(*key) is None for key in keys)]

    def run(self, kept: RowCheckpoint, progress: Callable[[Row], object]) -> pd.DataFrame:
        """Run the units of which a row is missing, and return the raw rows of all.

        Args:
            kept: Finished rows; a killed run continues with the unit that was cut off.
            progress: Called with each row, also with those that were kept.
        """
        rows: list[Row] = []
        for unit, keys in self.units().items():
            found = [row for key in keys if (row := kept.get(*key)) is not None]
            if len(found) < len(keys):
                found = self.unit(unit)
                for row in found:
                    kept.put(row)
            for row in found:
                rows.append(row)
                progress(row)
        return pd.DataFrame(rows)


def _line(row: Row) -> str:
    """A row as JSON after the checksum of its text."""
    text = json.dumps(row)
    return f"{_checksum(text)} {text}\n"


def _checksum(text: str) -> str:
    return f"{zlib.crc32(text.encode()):08x}"


def _whole_lines(path: Path) -> list[Row]:
    """Read whole lines; one that a kill cut off or a disk damaged is cut off the file as well."""
    if not path.exists():
        return []
    text = path.read_text(encoding="utf-8", errors="replace")
    rows: list[Row] = []
    whole = ""
    for line in text.splitlines():
        checksum, _, row = line.partition(" ")
        if checksum == _checksum(row):
            rows.append(json.loads(row))
            whole += f"{line}\n"
    if whole != text:
        write_text(path, whole)
    return rows
