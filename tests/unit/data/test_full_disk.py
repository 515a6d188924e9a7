"""Each kind of file on a disk that is full: the old one stays, and the error names the file."""

from __future__ import annotations

import errno
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from pipeline.data.files import naming, replacing, write_json, write_text
from pipeline.data.rows import RowCheckpoint
from pipeline.data.tables import write_table
from pipeline.data.tensors import write_tensors
from tests.disks import REFUSAL, full_disk

ROOM = 1000


def tensors(path: Path, size: int) -> None:
    write_tensors(path, {"weight": torch.arange(size, dtype=torch.float64)}, {"digest": "a"})


def table(path: Path, size: int) -> None:
    noise = np.random.default_rng(0).random(size)
    write_table(path, pd.DataFrame({"q0": noise}), {"seed": 1})


WRITERS: dict[str, Callable[[Path, int], None]] = {
    "a.safetensors": tensors,
    "a.parquet": table,
    "a.json": lambda path, size: write_json(path, {"rows": list(range(size))}),
    "a.csv": lambda path, size: write_text(path, "1,2,3\n" * size),
}


@pytest.mark.parametrize("name", WRITERS)
def test_the_old_file_stays_and_the_error_names_it(tmp_path: Path, name: str) -> None:
    path, write = tmp_path / name, WRITERS[name]
    write(path, 10)
    before = path.read_bytes()
    with full_disk(ROOM), pytest.raises(OSError, match=REFUSAL) as caught:
        write(path, 2000)
    assert caught.value.filename == str(path)
    assert list(tmp_path.iterdir()) == [path]
    assert path.read_bytes() == before
    write(path, 2000)
    assert len(path.read_bytes()) > ROOM


def test_a_row_that_found_no_room_is_cut_off_and_written_again(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    rows = [{"pair": pair, "note": "x" * 300} for pair in range(5)]
    kept = RowCheckpoint(path, ["pair"])
    with full_disk(ROOM), pytest.raises(OSError, match=REFUSAL) as caught:
        for row in rows:
            kept.put(row)
    assert caught.value.filename == str(path)
    again = RowCheckpoint(path, ["pair"])
    assert [again.get(pair) for pair in range(5)] == [*rows[:3], None, None]
    for row in rows[3:]:
        again.put(row)
    assert [RowCheckpoint(path, ["pair"]).get(pair) for pair in range(5)] == rows


def test_an_error_about_another_file_keeps_its_name(tmp_path: Path) -> None:
    other = tmp_path / "other.txt"
    with pytest.raises(FileNotFoundError) as caught, replacing(tmp_path / "a.json"):
        other.read_text()
    assert caught.value.filename == str(other)
    with pytest.raises(OSError, match="decoder") as raised, naming(tmp_path / "a.mp4"):
        raise OSError("no decoder")
    assert raised.value.errno is None
    with pytest.raises(PermissionError) as refused, naming(tmp_path / "a.mp4"):
        raise OSError(errno.EACCES, "refused")
    assert refused.value.filename == str(tmp_path / "a.mp4")
