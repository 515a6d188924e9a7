"""Which installed package a file came with, so that anybody can have the same one."""

from __future__ import annotations

import os
import sysconfig
from importlib.metadata import distributions
from pathlib import Path

RECORD = "RECORD"  # what a wheel has laid where, one path a line


def package_source(path: Path) -> str | None:
    """Return name and version of a file's package and the file's place in it; None without one.

    Args:
        path: The file, such as ``.../site-packages/pybullet_data/kuka_iiwa/model.urdf``, which is
            ``pybullet 3.2.7: pybullet_data/kuka_iiwa/model.urdf``.
    """
    libraries = Path(sysconfig.get_path("data")).resolve()
    path = path.resolve()
    if not path.is_relative_to(libraries):
        return None
    for package in distributions():
        root = Path(str(package.locate_file(""))).resolve()
        inside = Path(os.path.relpath(path, root)).as_posix()
        record = package.read_text(RECORD) or ""
        if f"\n{inside}," in f"\n{record}":
            return f"{package.metadata['Name']} {package.version}: {inside}"
    return None
