"""Checks of a whole URDF: that it is a URDF at all, a tree, and coupled without circles."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from pathlib import Path

from robots.errors import UrdfError
from robots.urdf import Joint, Link


def has_xacro(root: ElementTree.Element) -> bool:
    """Whether macros are left where they matter: among links and joints, or inside them."""
    if any("xacro" in child.tag for child in root):
        return True
    parts = [part for child in root if child.tag in ("link", "joint") for part in child.iter()]
    return any("${" in value or "$(" in value for part in parts for value in part.attrib.values())


def xacro_error(path: Path) -> UrdfError:
    """Say that a file is a xacro source."""
    return UrdfError(
        f"{path}: has xacro macros left in it, so it is a source of a URDF and not a URDF; "
        f"expand it first: xacro {path.name} > robot.urdf"
    )


def check_mimics(path: Path, joints: dict[str, Joint]) -> None:
    """Check that coupled joints follow joints that exist, and not themselves.

    Raises:
        UrdfError: If they do not.
    """
    for joint in joints.values():
        seen = [joint.name]
        master = joint
        while master.mimic is not None:
            if master.mimic.joint not in joints:
                raise UrdfError(
                    f"{path}: joint '{master.name}' mimics '{master.mimic.joint}', which is no "
                    f"joint of this file"
                )
            master = joints[master.mimic.joint]
            if master.name in seen:
                raise UrdfError(f"{path}: joints mimic in a circle: {' -> '.join(seen)}")
            seen.append(master.name)


def check_tree(path: Path, links: dict[str, Link], joints: dict[str, Joint]) -> str:
    """Return the root link of what must be one tree over all links.

    Raises:
        UrdfError: If a link is missing, has two parents, is in a loop, or there are more roots.
    """
    carrier: dict[str, str] = {}
    for joint in joints.values():
        for role, link in (("parent", joint.parent), ("child", joint.child)):
            if link not in links:
                raise UrdfError(
                    f"{path}: joint '{joint.name}' has the {role} link '{link}', which the file "
                    f"does not define"
                )
        if joint.child in carrier:
            raise UrdfError(
                f"{path}: link '{joint.child}' is the child of both '{carrier[joint.child]}' and "
                f"'{joint.name}': a loop; a URDF must be a tree"
            )
        carrier[joint.child] = joint.name
    for link in links:
        seen = {link}
        while link in carrier:
            link = joints[carrier[link]].parent
            if link in seen:
                raise UrdfError(f"{path}: the joints form a loop through link '{link}'")
            seen.add(link)
    roots = [link for link in links if link not in carrier]
    if len(roots) > 1:
        raise UrdfError(
            f"{path}: has {len(roots)} root links ({', '.join(roots[:5])}), expected one; connect "
            f"the others by joints"
        )
    return roots[0]
