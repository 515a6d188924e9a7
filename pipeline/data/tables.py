"""Parquet tables with named columns and their provenance in the schema metadata."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq

from pipeline.data.files import replacing

METADATA_KEY = b"cycleik_bench"
CHECKSUM_KEY = b"cycleik_bench_sha256"
METADATA_CHECKSUM_KEY = b"cycleik_bench_metadata_sha256"


class TableError(ValueError):
    """A table is missing, damaged, or does not hold what it should."""


def write_table(path: Path, frame: pd.DataFrame, metadata: Mapping[str, Any]) -> None:
    """Write raw rows to a Parquet file, atomically and with the same bytes for the same rows.

    Checksums over the column contents and over the metadata go into the schema, so that an edited
    or damaged file is noticed when it is read, whatever made it.

    Args:
        path: Parquet file to write; its folder is made.
        frame: The rows; the index is dropped.
        metadata: What made the rows (seeds, versions, configuration); must be JSON.
    """
    table = pa.Table.from_pandas(frame, preserve_index=False)
    facts = json.dumps(dict(metadata), sort_keys=True).encode()
    schema = {
        METADATA_KEY: facts,
        METADATA_CHECKSUM_KEY: hashlib.sha256(facts).hexdigest().encode(),
        CHECKSUM_KEY: _content_checksum(table).encode(),
    }
    with replacing(path) as partial:
        pq.write_table(table.replace_schema_metadata(schema), partial, compression="zstd")


def read_table(path: Path, columns: Sequence[str] | None = None) -> pd.DataFrame:
    """Read a table that `write_table` wrote and check that it is whole.

    Args:
        path: Parquet file.
        columns: Columns that the caller needs; all where left out.

    Returns:
        The rows, with ``columns`` in the requested order.

    Raises:
        TableError: There is no such file, it is cut off or was edited, or a column is missing.
    """
    with _parquet_errors_named(path):
        table = pq.read_table(path)
        _facts(path, table.schema.metadata or {})
        return _checked(path, table, columns)


def _checked(path: Path, table: pa.Table, columns: Sequence[str] | None) -> pd.DataFrame:
    stored = (table.schema.metadata or {}).get(CHECKSUM_KEY)
    if stored is None:
        raise TableError(f"{path} has no checksum: it was not written by this pipeline")
    if _content_checksum(table).encode() != stored:
        raise TableError(f"{path} was changed after it was written; make it again")
    missing = [name for name in columns or () if name not in table.column_names]
    if missing:
        raise TableError(f"{path} lacks the column(s) {', '.join(missing)}; make it again")
    return table.select(list(columns)).to_pandas() if columns else table.to_pandas()


def read_metadata(path: Path) -> dict[str, Any]:
    """Return the provenance that was stored with a table.

    Raises:
        TableError: There is no such file, or it is no table of this pipeline.
    """
    with _parquet_errors_named(path):
        return _facts(path, pq.read_schema(path).metadata or {})


def _facts(path: Path, metadata: Mapping[bytes, bytes]) -> dict[str, Any]:
    """The provenance in a schema, checked where the table has a checksum of it."""
    if METADATA_KEY not in metadata:
        raise TableError(f"{path} has no provenance: it was not written by this pipeline")
    facts = metadata[METADATA_KEY]
    stored = metadata.get(METADATA_CHECKSUM_KEY)
    if stored is not None and stored != hashlib.sha256(facts).hexdigest().encode():
        raise TableError(f"{path} was changed after it was written; make it again")
    return dict(json.loads(facts))


@contextmanager
def _parquet_errors_named(path: Path) -> Iterator[None]:
    try:
        yield
    except FileNotFoundError as error:
        raise TableError(f"there is no {path}") from error
    except TableError:
        raise
    except (pa.ArrowException, OSError, ValueError, KeyError, MemoryError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise TableError(f"{path} is not a readable Parquet file ({why}); make it again") from error


def _content_checksum(table: pa.Table) -> str:
    """SHA-256 over names, types and values; independent of chunking and compression."""
    digest = hashlib.sha256()
    for name, column in zip(table.column_names, table.columns, strict=True):
        digest.update(f"{name}:{column.type}:{len(column)}:{column.null_count}".encode())
        flat = column.combine_chunks()
        if pa.types.is_string(column.type) or pa.types.is_large_string(column.type):
            digest.update(json.dumps(flat.to_pylist()).encode())
            continue
        for part in (flat,) if isinstance(flat, pa.Array) else flat.chunks:
            digest.update(part.to_numpy(zero_copy_only=False).tobytes())
    return digest.hexdigest()
