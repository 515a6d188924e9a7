"""The help of a stage, kept from one call to the next.

To compose a configuration takes Hydra a second, and the help of a stage is the same until a file
changes that it is made of: a YAML of conf/ or a source. So the text is kept in the folder where
Python keeps the compiled sources, under a digest of the names, sizes and times of those files.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from collections.abc import Iterator, Sequence
from pathlib import Path

PACKAGES = Path(__file__).parents[2]
FOLDER = Path(__file__).parent / "__pycache__" / "help"
MADE_OF = ("conf", "pipeline", "baselines", "robots")
KEPT = 64  # texts, the latest ones


def kept_help(name: str, overrides: Sequence[str] = ()) -> str:
    """Return what `stage_help` says, from disk where it said so before.

    Args:
        name: Of a stage of the graph.
        overrides: Of the run in question.

    Raises:
        ConfigError: An override that cannot be.
    """
    path = FOLDER / f"{name}-{_digest(overrides)}.txt"
    with contextlib.suppress(OSError):
        return path.read_text(encoding="utf-8")
    from pipeline.commands.stage_help import stage_help

    text = stage_help(name, overrides)
    with contextlib.suppress(OSError):  # a folder of somebody else: the next call takes as long
        _keep(path, text)
    return text


def _keep(path: Path, text: str) -> None:
    from pipeline.data.files import write_text

    write_text(path, text)
    for old in sorted(FOLDER.glob("*.txt"), key=lambda each: each.stat().st_mtime)[:-KEPT]:
        old.unlink(missing_ok=True)


def _digest(overrides: Sequence[str]) -> str:
    """Digest of the overrides and of all files that a help is made of, as they are now."""
    digest = hashlib.sha256("\0".join(overrides).encode())
    for folder in MADE_OF:
        for entry in _files(PACKAGES / folder):
            facts = entry.stat()
            digest.update(f"{entry.path}\0{facts.st_size}\0{facts.st_mtime_ns}\n".encode())
    return digest.hexdigest()[:16]


def _files(folder: Path) -> Iterator[os.DirEntry[str]]:
    """Sources and YAML below a folder, in order."""
    try:
        entries = sorted(os.scandir(folder), key=lambda entry: entry.name)
    except OSError:  # conf/ lies elsewhere in an installed package: below pipeline
        return
    for entry in entries:
        if entry.is_dir():
            if entry.name != "__pycache__":
                yield from _files(Path(entry.path))
        elif entry.name.endswith((".py", ".yaml")):
            yield entry
