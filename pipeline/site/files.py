"""What lies beside the pages: figures, videos and rows, copied so that the folder stands alone."""

from __future__ import annotations

import filecmp
from collections.abc import Collection
from pathlib import Path

from pipeline.data.files import replacing, write_text
from pipeline.errors import PipelineError

OURS = "site.css"  # a folder that has it was written by us, if its pages say so too
SCRIPT = "site.js"
MARK = 'content="python -m pipeline site"'  # of every page, see page.html.jinja
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
    if folder.is_dir() and any(folder.iterdir()) and not _is_ours(folder):
        raise SiteError(f"{folder} holds other files; choose an empty folder by site.dir=...")
    for name in (OURS, SCRIPT):
        write_text(folder / name, Path(__file__).with_name(name).read_text(encoding="utf-8"))


def _is_ours(folder: Path) -> bool:
    pages = (path.read_text(encoding="utf-8", errors="replace") for path in folder.glob("*.html"))
    return (folder / OURS).exists() and all(MARK in text for text in pages)


def copied(source: Path, folder: Path, group: str, name: str) -> str:
    """Copy a file into a folder of the site and return its address, seen from the pages."""
    target = folder / group / name
    if not target.exists() or not filecmp.cmp(source, target, shallow=False):
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
