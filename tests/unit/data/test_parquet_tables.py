"""Tables: same bytes for same rows, damage noticed, the old file or the new one."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.data.files import replacing
from pipeline.data.tables import TableError, read_metadata, read_table, write_table

FRAME = pd.DataFrame(
    {"pose": [0, 1, 2], "error": [0.5, np.nan, 1e-300], "reason": ["", "late", None]}
)


def test_rows_and_provenance_come_back(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "rows.parquet"
    write_table(path, FRAME, {"seed": 7})
    pd.testing.assert_frame_equal(read_table(path), FRAME)
    assert list(read_table(path, ["reason", "pose"]).columns) == ["reason", "pose"]
    assert read_metadata(path) == {"seed": 7}
    first = path.read_bytes()
    write_table(path, FRAME, {"seed": 7})
    assert path.read_bytes() == first


@given(st.integers(0, 400))
def test_a_file_cut_anywhere_is_named(tmp_path_factory: pytest.TempPathFactory, cut: int) -> None:
    path = tmp_path_factory.mktemp("cut") / "rows.parquet"
    write_table(path, FRAME, {})
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) * cut // 401])
    with pytest.raises(TableError, match=r"rows.parquet"):
        read_table(path)


def test_an_edited_value_is_noticed(tmp_path: Path) -> None:
    path = tmp_path / "rows.parquet"
    write_table(path, FRAME, {})
    table = pq.read_table(path)
    edited = table.to_pandas()
    edited.loc[0, "error"] = 0.25
    changed = table.from_pandas(edited, preserve_index=False)
    pq.write_table(changed.replace_schema_metadata(table.schema.metadata), path)
    with pytest.raises(TableError, match="was changed after it was written"):
        read_table(path)


def test_a_foreign_or_missing_table_and_a_missing_column_are_named(tmp_path: Path) -> None:
    foreign = tmp_path / "foreign.parquet"
    FRAME.to_parquet(foreign)
    with pytest.raises(TableError, match="not written by this pipeline"):
        read_table(foreign)
    with pytest.raises(TableError, match="there is no"):
        read_table(tmp_path / "none.parquet")
    write_table(tmp_path / "rows.parquet", FRAME, {})
    with pytest.raises(TableError, match="lacks the column"):
        read_table(tmp_path / "rows.parquet", ["q0"])


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path: Path) -> None:
    path = tmp_path / "card.json"
    path.write_text("old")
    with pytest.raises(RuntimeError), replacing(path) as partial:
        partial.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
