"""Where numba keeps compiled code, so that an edit is never answered by stale code.

Numba recompiles a function when its own file changes, but not when a function it calls changes
in another file, and ours call each other across files. So the folder of the cache is named after
the contents of all files with compiled functions.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import Any

import numba.core.caching
import numba.core.config

from robots.collector_pause import pause_collector_while_compiling
from robots.compile_notice import announce_compiling

ROOT = Path(__file__).parents[1]
# What unpickling half a file raises.
CUT_OFF = (
    *(pickle.UnpicklingError, EOFError, ValueError, TypeError),
    *(KeyError, IndexError, AttributeError, ImportError),
)


def source_digest(*folders: Path) -> str:
    """Short hash over the files with compiled functions directly in some folders.

    Args:
        folders: Folders of packages.
    """
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted(folder.glob("*.py")):
            text = path.read_bytes()
            if b"njit" in text:
                digest.update(path.name.encode() + text)
    return digest.hexdigest()[:16]


def use_own_folder(*packages: str) -> None:
    """Point numba to a folder per state of the sources; NUMBA_CACHE_DIR of the user wins.

    From then on, when compiled functions are not there yet, a line says so and the collector waits.

    To be called before the compiled functions of a package are declared: numba looks at the
    setting then and not later.

    Args:
        packages: The package and those whose compiled functions it calls.
    """
    announce_compiling()
    pause_collector_while_compiling()
    numba.core.caching.IndexDataCacheFile = _CacheFile
    if not os.environ.get("NUMBA_CACHE_DIR"):
        digest = source_digest(*(ROOT / package for package in packages))
        folder = ROOT / packages[0] / "__pycache__" / f"numba-{digest}"
        if not _is_writable(folder):
            # A checkout or an installation of somebody else: the user's own cache, if that can be.
            folder = _user_cache() / f"{packages[0]}-{digest}"
        numba.core.config.CACHE_DIR = str(folder)


def _is_writable(folder: Path) -> bool:
    """Whether files can be made in a folder, or in what it would be made in."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    return folder.is_dir() and os.access(folder, os.W_OK | os.X_OK)


def _user_cache() -> Path:
    home = os.environ.get("XDG_CACHE_HOME") or str(Path("~").expanduser() / ".cache")
    folder = Path(home) / "cycleik-bench"
    return folder if _is_writable(folder) else Path(tempfile.gettempdir()) / "cycleik-bench"


class _CacheFile(numba.core.caching.IndexDataCacheFile):
    """The files of one function, of which no damage and no full disk stops a call.

    Numba raises what unpickling half a file gives, and the disk's error where it cannot write. Here
    a file that is cut off is one that is missing, and what cannot be kept is compiled again.
    """

    def save(self, key: Any, data: Any) -> None:
        """Keep compiled code if the disk takes it."""
        with suppress(OSError):
            super().save(key, data)

    def _load_index(self) -> dict[Any, str]:
        try:
            return dict(super()._load_index())
        except CUT_OFF:
            return {}

    def _load_data(self, name: str) -> Any:
        try:
            return super()._load_data(name)
        except CUT_OFF as error:
            raise FileNotFoundError(name) from error  # which numba expects
