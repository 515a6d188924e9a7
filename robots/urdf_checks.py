"""Checks of a whole URDF: that it is a tree, and coupled without circles."""

from __future__ import annotations

from pathlib import Path

from robots.errors import UrdfError
from robots.urdf import Joint, Link


def broken_mimics(joints: dict[str, Joint]) -> dict[str, str]:
    """Find coupled joints whose masters do not exist or follow themselves in the end.

    Args:
        joints: All joints by name.

    Returns:
        Joint name to one sentence; nothing where all couplings are sound.
    """
    broken = {}
    for joint in joints.values():
        seen = [joint.name]
        master = joint
        while master.mimic is not None:
            if master.mimic.joint not in joints:
                broken[joint.name] = (
                    f"joint '{master.name}' mimics '{master.mimic.joint}', which is no joint of "
                    f"this file"
                )
                break
            master = joints[master.mimic.joint]
            if master.name in seen:
                broken[joint.name] = f"joints mimic in a circle: {' -> '.join(seen)}"
                break
            seen.append(master.name)
    return broken


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
