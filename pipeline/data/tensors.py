"""Tensors on disk: safetensors files that are whole or not there."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from safetensors.torch import save
from torch import Tensor

from pipeline.data.files import replacing


def write_tensors(
    path: Path, tensors: Mapping[str, Tensor], header: dict[str, str] | None = None
) -> None:
    """Write tensors to a safetensors file, atomically.

    The bytes are made first and written by Python: what the disk refuses is then an OSError like
    any other, which the library's own writer turns into an error of its own.

    Args:
        path: The file that is to appear. Its folder is made.
        tensors: By name, on any device.
        header: Text that goes with them.
    """
    content = save({name: value.contiguous().cpu() for name, value in tensors.items()}, header)
    with replacing(path) as partial:
        partial.write_bytes(content)
