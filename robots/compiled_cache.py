"""Where numba keeps compiled code, so that an edit is never answered by stale code.

Numba recompiles a function when its own file changes, but not when a function it calls changes
in another file, and ours call each other across files. So the folder of the cache is named after
the contents of all files with compiled functions.
"""

from __future__ import annotations

import hashlib
import os
from pathlib import Path

import numba.core.config

ROOT = Path(__file__).parents[1]


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

    To be called before the compiled functions of a package are declared: numba looks at the
    setting then and not later.

    Args:
        packages: The package and those whose compiled functions it calls.
    """
    if not os.environ.get("NUMBA_CACHE_DIR"):
        digest = source_digest(*(ROOT / package for package in packages))
        folder = ROOT / packages[0] / "__pycache__" / f"numba-{digest}"
        numba.core.config.CACHE_DIR = str(folder)
