"""Rows of an experiment kept as JSON lines while it runs, so that a killed one goes on."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from pipeline.data.files import write_text

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
        with self.path.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(row) + "\n")
        self._rows[self._key(row)] = row

    def clear(self) -> None:
        """Remove the file; to be called when the rows are safely written elsewhere."""
        self.path.unlink(missing_ok=True)

    def _key(self, row: Row) -> tuple[object, ...]:
        return tuple(row[name] for name in self.key)


def _whole_lines(path: Path) -> list[Row]:
    """Read whole JSON lines; a line that a kill cut off is cut off the file as well."""
    if not path.exists():
        return []
    text = path.read_text(encoding="utf-8", errors="replace")
    rows: list[Row] = []
    whole = ""
    for line in text.splitlines():
        try:
            rows.append(json.loads(line))
        except ValueError:
            break
        whole += f"{line}\n"
    if whole != text:
        write_text(path, whole)
    return rows
