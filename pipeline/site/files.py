"""What lies beside the pages: figures, videos and rows, copied so that the folder stands alone."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from pipeline.data.files import replacing, write_text
from pipeline.errors import PipelineError

OURS = "site.css"  # a folder that has it was written by us
SCRIPT = "site.js"
KEPT = ("*.html", "data/*.csv", "figures/*", "media/**/*")  # what a site writes, and renews


class SiteError(PipelineError):
    """A folder that pages cannot be written into."""


def claim(folder: Path) -> None:
    """Make a folder ours by its style and script, if it holds nothing else.

    Args:
        folder: Of the pages.

    Raises:
        SiteError: It is not empty and no earlier site, or no folder.
    """
    if folder.exists() and not folder.is_dir():
        raise SiteError(f"site.dir={folder} is a file; expected a folder")
    if folder.is_dir() and any(folder.iterdir()) and not (folder / OURS).exists():
        raise SiteError(f"{folder} holds other files; choose an empty folder by site.dir=...")
    for name in (OURS, SCRIPT):
        write_text(folder / name, Path(__file__).with_name(name).read_text(encoding="utf-8"))


def copied(source: Path, folder: Path, group: str, name: str) -> str:
    """Copy a file into a folder of the site and return its address, seen from the pages."""
    target = folder / group / name
    if not _same(source, target):
        with replacing(target) as partial:
            partial.write_bytes(source.read_bytes())
    return f"{group}/{name}"


def remove_others(folder: Path, written: Collection[str]) -> None:
    """Remove what an earlier site wrote and this one did not.

    Args:
        folder: Of the site.
        written: Addresses, seen from the pages.
    """
    for pattern in KEPT:
        for path in folder.glob(pattern):
            if path.is_file() and path.relative_to(folder).as_posix() not in written:
                path.unlink()


def _same(source: Path, target: Path) -> bool:
    if not target.exists():
        return False
    a, b = source.stat(), target.stat()
    return a.st_size == b.st_size and a.st_mtime <= b.st_mtime
