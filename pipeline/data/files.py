"""Files that are either the old one or the new one, never half of one."""

from __future__ import annotations

import glob
import hashlib
import json
import os
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import yaml

from pipeline.errors import PipelineError

CHUNK_BYTES = 1 << 20
PARTIAL = "partial"
YAML_END = "...\n"
YAML_SEAL, YAML_HINT = "# sha256 ", "; remove this line after an edit\n"
SEAL = "content_sha256"  # key of a sealed JSON object: the checksum of all its others


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
    old file or the new one. On an exception the temporary file is removed and ``path`` stays. What
    a killed process left of an earlier attempt is removed.

    Args:
        path: The file that is to appear. Its folder is made.

    Yields:
        The path to write to; it keeps the suffix of ``path``, which some writers look at.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    writer = f"{platform.node()}-{os.getpid()}"
    partial = path.with_name(f".{path.stem}.{writer}.{PARTIAL}{path.suffix}")
    _remove_abandoned(path)
    try:
        with naming(path, partial):
            yield partial
            with partial.open("rb") as stream:
                os.fsync(stream.fileno())
            partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def _remove_abandoned(path: Path) -> None:
    """Remove temporary files of a path whose writer, a process of this machine, was killed."""
    begin, end = f".{path.stem}.{platform.node()}-", f".{PARTIAL}{path.suffix}"
    for found in path.parent.glob(f".{glob.escape(path.stem)}.*{end}"):
        number = found.name.removeprefix(begin).removesuffix(end)
        if number.isdecimal() and not _is_alive(int(number)):
            found.unlink(missing_ok=True)


def _is_alive(number: int) -> bool:
    try:
        os.kill(number, 0)
    except ProcessLookupError:
        return False
    except OSError:  # somebody else's
        return True
    return True


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
        raise OSError(error.errno, error.strerror, str(path)) from error


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
        partial.write_text(_json(content) + "\n", encoding="utf-8")


def write_sealed_json(path: Path, content: dict[str, Any]) -> None:
    """Write an object as JSON with its own checksum in it, which `read_json` checks."""
    write_json(path, {**content, SEAL: _content_checksum(content)})


def _content_checksum(content: dict[str, Any]) -> str:
    """Checksum of an object as JSON gives it back: with texts as keys, say."""
    return hashlib.sha256(_json(json.loads(_json(content))).encode()).hexdigest()


def _json(content: Any) -> str:
    return json.dumps(content, indent=2, sort_keys=True)


def write_text(path: Path, content: str) -> None:
    """Write a text file, atomically."""
    with replacing(path) as partial:
        partial.write_text(content, encoding="utf-8")


def read_json(path: Path) -> Document:
    """Read a JSON file that holds an object.

    Raises:
        FileError: The file is no JSON or holds no object, or was changed after it was sealed, or
            later: a key is requested that it lacks.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise FileError(f"{path} is not readable as JSON ({error}); make it again") from error
    if not isinstance(content, dict):
        raise FileError(f"{path} must hold an object, got {_kind(content)}; make it again")
    seal = content.pop(SEAL, None)
    if seal is not None and seal != _content_checksum(content):
        raise FileError(f"{path} was changed after it was written; make it again")
    return Document(path, content)


def check_listed(path: Path, card: Mapping[str, Any]) -> None:
    """Compare a file with the checksum that a card has of it, if it has one.

    Raises:
        FileError: It is another file.
    """
    listed = card.get("files", {}).get(path.name)
    if listed is not None and listed != sha256(path):
        raise FileError(f"{path} was changed after it was written; make it again")


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


def write_sealed_yaml(path: Path, text: str) -> None:
    """Write YAML with its end and checksum, which `read_sealed_yaml` checks.

    Args:
        path: The file.
        text: A mapping as YAML, with comments and a final newline.
    """
    checksum = hashlib.sha256(text.encode()).hexdigest()
    write_text(path, f"{text}{YAML_END}{YAML_SEAL}{checksum}{YAML_HINT}")


def read_sealed_yaml(path: Path) -> dict[str, Any]:
    """Read what `write_sealed_yaml` wrote; without its last line it may have been edited.

    Raises:
        FileError: It cannot be read, is cut off, or was changed under its checksum.
    """
    content = read_yaml(path)
    text, end, seal = path.read_text(encoding="utf-8").rpartition(YAML_END)
    if not end:
        raise FileError(f"{path} is cut off: a line '...' must end it; make it again")
    checksum = hashlib.sha256(text.encode()).hexdigest()
    if seal.startswith(YAML_SEAL) and seal != f"{YAML_SEAL}{checksum}{YAML_HINT}":
        raise FileError(
            f"{path} was changed after it was written; remove its last line if that was you, or "
            "make it again"
        )
    return content


def _kind(content: object) -> str:
    return "nothing" if content is None else f"a {type(content).__name__}"
