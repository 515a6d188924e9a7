"""Chunks of raw rows on disk, so that a killed evaluation goes on where it was."""

from __future__ import annotations

import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.data.tables import TableError, read_metadata, read_table, write_table


class ChunkCache:
    """A folder of finished chunks that all stem from one and the same question.

    Args:
        folder: Where the chunks lie; it is made when the first is put. None keeps nothing.
        cache_key: What the rows depend on (robot, solver, poses, configuration), as JSON. Chunks of
            another question are not used.
    """

    def __init__(self, folder: Path | None, cache_key: dict[str, Any]) -> None:
        self.folder = folder
        text = json.dumps(cache_key, sort_keys=True, default=str)
        self.key = hashlib.sha256(text.encode()).hexdigest()

    def get(self, name: str) -> pd.DataFrame | None:
        """Return the rows of a chunk, or None where it is not there, damaged or of old."""
        if self.folder is None:
            return None
        path = self.folder / f"{name}.parquet"
        try:
            if read_metadata(path).get("key") != self.key:
                return None
            return read_table(path)
        except TableError:
            return None

    def put(self, name: str, rows: pd.DataFrame) -> None:
        """Keep the rows of a finished chunk."""
        if self.folder is not None:
            write_table(self.folder / f"{name}.parquet", rows, {"key": self.key})

    def clear(self) -> None:
        """Remove all chunks: the whole table is safely written."""
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)


def array_checksum(array: NDArray[np.float64]) -> str:
    """Return the SHA-256 of an array's shape and values."""
    digest = hashlib.sha256(str(array.shape).encode())
    digest.update(np.ascontiguousarray(array, dtype=np.float64).tobytes())
    return digest.hexdigest()
