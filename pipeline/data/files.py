"""Files that are either the old one or the new one, never half of one."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from pipeline.errors import PipelineError

CHUNK_BYTES = 1 << 20


class FileError(PipelineError):
    """A file of JSON or YAML that cannot be read, or that lacks what every such file has."""


class Document(dict[str, Any]):
    """The object of a JSON file; asking it for a key that it lacks names the file."""

    def __init__(self, path: Path, content: dict[str, Any]) -> None:
        super().__init__(content)
        self.path = path

    def __missing__(self, key: str) -> Any:
        raise FileError(f"{self.path} has no '{key}'; make it again")


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """Yield a path beside ``path`` to write to, and put it in place when all went well.

    The temporary file is on the same file system, so the final rename is atomic: a reader sees the
    old file or the new one. On an exception the temporary file is removed and ``path`` stays.

    Args:
        path: The file that is to appear. Its folder is made.

    Yields:
        The path to write to; it keeps the suffix of ``path``, which some writers look at.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.stem}.{os.getpid()}.partial{path.suffix}")
    try:
        with naming(path, partial):
            yield partial
            with partial.open("rb") as stream:
                os.fsync(stream.fileno())
            partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


@contextmanager
def naming(path: Path, partial: Path | None = None) -> Iterator[None]:
    """Let an OSError that names no file, as that of a full disk, say which one was written.

    Args:
        path: The file that is written.
        partial: Where it is written to meanwhile, a name that tells a user nothing.
    """
    try:
        yield
    except OSError as error:
        if error.errno is None or error.filename not in (None, str(partial), partial):
            raise
        raise OSError(error.errno, os.strerror(error.errno), str(path)) from error


def sha256(path: Path) -> str:
    """Return the SHA-256 of a file's bytes as 64 hexadecimal digits."""
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(CHUNK_BYTES):
            digest.update(block)
    return digest.hexdigest()


def write_json(path: Path, content: Any) -> None:
    """Write ``content`` as indented JSON with a final newline, atomically."""
    with replacing(path) as partial:
        partial.write_text(json.dumps(content, indent=2, sort_keys=True) + "\n", encoding="utf-8")


def write_text(path: Path, content: str) -> None:
    """Write a text file, atomically."""
    with replacing(path) as partial:
        partial.write_text(content, encoding="utf-8")


def read_json(path: Path) -> Document:
    """Read a JSON file that holds an object.

    Raises:
        FileError: The file is no JSON or holds no object, or later: a key is requested that it
            lacks.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise FileError(f"{path} is not readable as JSON ({error}); make it again") from error
    if not isinstance(content, dict):
        raise FileError(f"{path} must hold an object, got {_kind(content)}; make it again")
    return Document(path, content)


def read_yaml(path: Path) -> dict[str, Any]:
    """Read a YAML file that holds a mapping.

    Raises:
        FileError: There is no such file, it is no YAML, or it holds no mapping.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FileError(f"{path} cannot be read: {error.strerror or error}") from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise FileError(f"{path} is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(content, dict):
        raise FileError(f"{path} must hold a mapping (key: value), got {_kind(content)}")
    return content


def _kind(content: object) -> str:
    return "nothing" if content is None else f"a {type(content).__name__}"
