"""Tensors on disk: safetensors files that are whole or not there."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save
from torch import Tensor

from pipeline.data.files import replacing

CHECKSUM = "sha256"  # key of the header of a sealed file


class TensorsError(ValueError):
    """A file of tensors that is damaged."""


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


def write_sealed_tensors(path: Path, tensors: Mapping[str, Tensor], header: dict[str, str]) -> None:
    """Write tensors like `write_tensors`, with a checksum of them and of their header."""
    write_tensors(path, tensors, {**header, CHECKSUM: _checksum(tensors, header)})


def read_sealed_tensors(path: Path) -> tuple[dict[str, Tensor], dict[str, str]]:
    """Read what `write_sealed_tensors` wrote: the tensors, on the CPU, and their header.

    Raises:
        TensorsError: It is cut off or was changed.
        FileNotFoundError: There is no such file.
    """
    try:
        with safe_open(path, framework="pt") as stream:
            header = dict(stream.metadata() or {})
            tensors = {name: stream.get_tensor(name) for name in stream.keys()}  # noqa: SIM118
    except FileNotFoundError:
        raise
    except (SafetensorError, OSError, ValueError, RuntimeError) as error:
        raise TensorsError(f"{path} is not readable as safetensors: {error}") from error
    if header.pop(CHECKSUM, "") != _checksum(tensors, header):
        raise TensorsError(f"{path} was changed after it was written")
    return tensors, header


def _checksum(tensors: Mapping[str, Tensor], header: Mapping[str, str]) -> str:
    digest = hashlib.sha256(repr(sorted(header.items())).encode())
    for name, tensor in sorted(tensors.items()):
        digest.update(f"{name}:{tensor.dtype}:{tuple(tensor.shape)}".encode())
        values = tensor.detach().cpu().contiguous().reshape(-1)
        digest.update(values.view(torch.uint8).numpy().data)
    return digest.hexdigest()
