"""What made an artifact: versions, machine, commit, configuration; cards have no clock in them."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import subprocess
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pipeline.containers import to_dict
from robots.locations import FOLDER

if TYPE_CHECKING:
    from pipeline.settings import Config

PACKAGES = (
    "numpy",
    "torch",
    "pytorch-kinematics",
    "pin",
    "coal",
    "placo",
    "numba",
    "pybullet",
    "optuna",
    "hydra-core",
    "pandas",
    "pyarrow",
    "dvc",
)
NO_COMMIT = "no commit"
DIFFERENCES = ("status", "--porcelain", "-uno", "--", ".", ":(exclude)results/*/*")


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that shape results."""
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found


@cache
def machine() -> dict[str, Any]:
    """Return processor, cores and system of this machine."""
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)),
        "system": f"{platform.system()} {platform.machine()}",
    }


@cache
def commit() -> str:
    """Return the commit of this checkout, with ``+changes`` where files differ from it.

    Files in folders of results/ do not count: a run has written some when it says what it was run
    from.

    Where there is no checkout under git (an unpacked archive, an installed package), "no commit".
    """
    try:
        if Path(_git("rev-parse", "--show-toplevel")) != FOLDER:  # a repository around this one
            return NO_COMMIT
        head = _git("rev-parse", "--short=12", "HEAD")
        return f"{head}+changes" if _git(*DIFFERENCES) else head
    except (OSError, subprocess.CalledProcessError):
        return NO_COMMIT


def digest(content: Any) -> str:
    """Return 16 hexadecimal digits that name a JSON-like content."""
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def card(*sections: str, config: Config, **facts: Any) -> dict[str, Any]:
    """Return the card that lies beside an artifact.

    Args:
        *sections: Groups of the configuration that shaped it.
        config: The configuration of the run.
        **facts: What else there is to say: seeds, counts, checksums, metrics.
    """
    whole = to_dict(config)
    used = {name: whole[name] for name in ("seed", *sections)}
    return {**facts, "config": used, **made_by()}


def made_by() -> dict[str, Any]:
    """Return versions and machine: the part of a card that no stage chooses.

    The commit is not in it: later stages depend on cards, and a commit that changed nothing else
    would make all of them run again. Rows at the end of the line carry it (`commit`).
    """
    return {"versions": versions(), "machine": machine()}


def signature(profile: str) -> dict[str, str]:
    """Return what rows at the end of the line carry besides: commit, day (UTC) and profile.

    No later stage but the report depends on them, so a new day makes nothing run again.
    """
    return {"commit": commit(), "date": datetime.now(UTC).date().isoformat(), "profile": profile}


def _git(*arguments: str) -> str:
    command = ["git", "-C", str(FOLDER), *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    except OSError:
        pass
    return platform.processor() or "unknown"
