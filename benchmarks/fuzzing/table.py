"""Counts of the attacks as a table that grows: one row an attack and its target."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pandas as pd
from filelock import FileLock

from benchmarks.studies import write_study

OUT = Path(__file__).parents[2] / "results" / "studies" / "fuzzing.csv"
KEY = ["attack", "target"]
COMMAND = "python -m benchmarks.fuzzing urdfs|arguments|kills|files|disks"
TITLE = """\
# Odd input, kills and damaged files

*count*: inputs, kills or damaged files; *bad*: ended in a traceback, after more than ten seconds
of the processor, with a wrong answer or half a file. *refused*: in one sentence; *anew*: what was
damaged is made again.
"""


def record(row: dict[str, Any]) -> None:
    """Put a row into the table, in place of an earlier one of the same attack and target."""
    OUT.parent.mkdir(parents=True, exist_ok=True)
    with FileLock(OUT.with_name(f".{OUT.name}.lock")):
        _put(row)


def _put(row: dict[str, Any]) -> None:
    table = pd.read_csv(OUT) if OUT.exists() else pd.DataFrame(columns=KEY)
    others = table[~(table[KEY] == pd.Series({key: row[key] for key in KEY})).all(axis=1)]
    table = pd.DataFrame([*others.to_dict("records"), row])
    front = [*KEY, "count", "bad"]
    table = table[front + [name for name in table if name not in front]].convert_dtypes()
    table = table.sort_values(KEY, ignore_index=True)
    text = TITLE + "\n" + _markdown(table)
    write_study(OUT.stem, table, text, COMMAND, "0")


def _markdown(table: pd.DataFrame) -> str:
    lines = [list(table.columns), ["---"] * len(table.columns)]
    for _, row in table.iterrows():
        lines.append(["" if pd.isna(value) else str(value) for value in row])
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)
