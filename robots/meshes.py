"""Where the mesh of a URDF lies on this machine."""

from __future__ import annotations

import os
from pathlib import Path

from robots.errors import UrdfError


def resolve_mesh(reference: str, urdf: Path, where: str) -> Path:
    """Find the file that a URDF's mesh filename means.

    `package://name/rest` is looked for as `name/rest` and `rest` in the URDF's folder, in every
    folder above it, and in those of the environment variable ROS_PACKAGE_PATH; anything else is
    a path relative to the URDF.

    Args:
        reference: The filename attribute.
        urdf: The file it stands in.
        where: Whose mesh it is, for the message.

    Raises:
        UrdfError: If no such file is there.
    """
    scheme, _, rest = reference.rpartition("://")
    if scheme in ("", "file"):
        found = urdf.parent / rest
        if found.is_file():
            return found.resolve()
        raise UrdfError(f"{urdf}: {where} wants the mesh '{reference}', which is not there")
    if scheme not in ("package", "model"):
        raise UrdfError(f"{urdf}: {where} wants the mesh '{reference}'; only files and package://")
    for folder in _search_path(urdf):
        # A folder of ROS_PACKAGE_PATH holds packages or is one, so both readings count.
        for candidate in (folder / rest, folder / Path(*Path(rest).parts[1:])):
            if candidate.is_file():
                return candidate.resolve()
    raise UrdfError(
        f"{urdf}: {where} wants the mesh '{reference}', which is not below the URDF's folder, "
        f"those above it, or ROS_PACKAGE_PATH; set ROS_PACKAGE_PATH to where the package lies"
    )


def _search_path(urdf: Path) -> list[Path]:
    parents = list(urdf.resolve().parents)
    listed = os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep)
    return parents + [Path(entry) for entry in listed if entry]
