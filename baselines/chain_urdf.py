"""A URDF of the chain alone, for libraries that read URDF files themselves.

Everything that these parsers stumble over is left out: meshes, other branches, transmissions, and
`<safety_controller>` (pytracik reads joint limits as 0 where that is present). Limits are those
of the robot, so that every solver searches the same box; continuous joints become revolute.
"""

from __future__ import annotations

import copy
import tempfile
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from baselines.errors import SolverError

if TYPE_CHECKING:
    from robots import Robot

# Used by libraries that insist on a number; inverse kinematics does not depend on it.
EFFORT = 100.0


def chain_urdf(robot: Robot) -> str:
    """URDF text of the serial chain from `robot.base` (its root) to `robot.tip`.

    Raises:
        SolverError: The URDF has no path from tip to base.
    """
    document = ElementTree.parse(robot.urdf_path).getroot()
    by_child = {_link(joint, "child"): joint for joint in document.findall("joint")}
    path: list[ElementTree.Element] = []
    link = robot.tip
    while link != robot.base:
        if link not in by_child:
            raise SolverError(f"{robot.urdf_path}: no path from {robot.tip!r} to {robot.base!r}")
        path.insert(0, by_child[link])
        link = _link(by_child[link], "parent")
    result = ElementTree.Element("robot", name=robot.name)
    ElementTree.SubElement(result, "link", name=robot.base)
    for joint in path:
        result.append(_bare_joint(joint, robot))
        ElementTree.SubElement(result, "link", name=_link(joint, "child"))
    return ElementTree.tostring(result, encoding="unicode")


@contextmanager
def chain_urdf_file(robot: Robot) -> Iterator[Path]:
    """The text of `chain_urdf` as a file that is removed afterwards."""
    with tempfile.TemporaryDirectory(prefix="chain_urdf_") as folder:
        path = Path(folder) / "chain.urdf"
        path.write_text(chain_urdf(robot))
        yield path


def _link(joint: ElementTree.Element, role: str) -> str:
    element = joint.find(role)
    return "" if element is None else element.get("link", "")


def _bare_joint(joint: ElementTree.Element, robot: Robot) -> ElementTree.Element:
    """Copy of a joint with kinematics and limits only."""
    name = joint.get("name", "")
    movable = name in robot.joint_names
    kind = joint.get("type", "fixed") if movable else "fixed"
    bare = ElementTree.Element(
        "joint", name=name, type="revolute" if kind == "continuous" else kind
    )
    for tag in ("origin", "parent", "child", "axis"):
        element = joint.find(tag)
        if element is not None and (movable or tag != "axis"):
            bare.append(copy.deepcopy(element))
    if movable:
        index = list(robot.joint_names).index(name)
        ElementTree.SubElement(
            bare,
            "limit",
            lower=repr(float(robot.lower[index])),
            upper=repr(float(robot.upper[index])),
            velocity=repr(float(robot.velocity_limit[index])),
            effort=repr(EFFORT),
        )
    return bare
