"""A copy of this project without git, as from an archive: what is tracked, or all but results."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

from robots.locations import FOLDER

LEFT_OUT = (".git", ".venv", "results", "build", "__pycache__", "*.egg-info", ".*_cache")


def unpack(into: Path) -> Path:
    """Copy the project to a folder that is not there yet and return it."""
    listed = subprocess.run(
        ["git", "-C", str(FOLDER), "ls-files"], capture_output=True, text=True, check=False
    )
    if listed.returncode == 0 and (FOLDER / ".git").exists():
        for name in listed.stdout.splitlines():
            target = into / name
            target.parent.mkdir(parents=True, exist_ok=True)
            if (FOLDER / name).is_file():
                shutil.copy2(FOLDER / name, target)
        return into
    shutil.copytree(FOLDER, into, ignore=shutil.ignore_patterns(*LEFT_OUT))
    (into / "results").mkdir()
    shutil.copy2(FOLDER / "results" / "published_results.csv", into / "results")
    return into
