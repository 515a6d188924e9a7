"""Plain XML from a checked URDF, for parsers that are less forgiving or less careful than ours.

What they stumble over is gone: `<safety_controller>` (pytracik then reads the limits as zero),
transmissions, Gazebo extensions, `package://`. For models continuous joints are written as revolute
with limits of -pi and pi, so that every library has one number per joint; joints of zero width
become fixed. A coupled joint is written with its coupling as long as its master is written too.
"""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robots.rotations import matrix_from_axis_angle, rpy_from_matrix
from robots.urdf import Joint, Link, Shape, Urdf

Array = NDArray[np.float64]
Namer = Callable[[Path], str]
NO_LIMIT = 1e6


def write_urdf(
    urdf: Urdf,
    root: str | None = None,
    shapes: bool = True,
    mesh_name: Namer = str,
    still: Mapping[str, float] | None = None,
    continuous: bool = False,
) -> str:
    """XML of a URDF or of the part of it below a link.

    Args:
        urdf: What to write.
        root: The link to start from, which becomes the root; the whole tree if not given.
        shapes: Whether to write visual and collision shapes.
        mesh_name: How to write the path of a mesh; the absolute path if not given.
        still: Positions of joints that are written as fixed there, rad or m; with them, no
            couplings are written.
        continuous: Whether to write joints that turn for ever as what they are.

    Returns:
        The document, with 17 digits for every number, so that nothing is lost.
    """
    robot = ElementTree.Element("robot", name=urdf.name)
    links = below(urdf, root or urdf.root)
    for link in links:
        robot.append(_link(urdf.links[link], shapes, mesh_name))
    for joint in urdf.joints.values():
        if joint.parent in links:
            coupled = still is None and _has_master(urdf, joint, links)
            kind = "continuous" if joint.endless and continuous else _plain_kind(joint)
            robot.append(_joint(joint, kind, coupled, (still or {}).get(joint.name)))
    ElementTree.indent(robot)
    return ElementTree.tostring(robot, encoding="unicode", xml_declaration=True) + "\n"


def below(urdf: Urdf, root: str) -> dict[str, None]:
    """Name the links of the subtree under a link, that link first (a dict as an ordered set)."""
    found = {root: None}
    # Joints may come in any order in the file, so sweep until nothing is added.
    while True:
        more = {j.child: None for j in urdf.joints.values() if j.parent in found}
        if more.keys() <= found.keys():
            return found
        found.update(more)


def _has_master(urdf: Urdf, joint: Joint, links: dict[str, None]) -> bool:
    return joint.mimic is not None and urdf.joints[joint.mimic.joint].parent in links


def _numbers(values: tuple[float, ...] | Array) -> str:
    return " ".join(np.format_float_positional(float(v), trim="-") for v in values)


def _origin(pose: Array) -> ElementTree.Element:
    return ElementTree.Element(
        "origin", xyz=_numbers(pose[:3, 3]), rpy=_numbers(rpy_from_matrix(pose[:3, :3]))
    )


def _link(link: Link, shapes: bool, mesh_name: Namer) -> ElementTree.Element:
    element = ElementTree.Element("link", name=link.name)
    if link.inertial is not None:
        inertial = ElementTree.SubElement(element, "inertial")
        inertial.append(_origin(link.inertial.origin))
        ElementTree.SubElement(inertial, "mass", value=_numbers((link.inertial.mass,)))
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        values = {k: _numbers((v,)) for k, v in zip(keys, link.inertial.inertia, strict=True)}
        ElementTree.SubElement(inertial, "inertia", values)
    if shapes:
        element.extend(_shape("visual", shape, mesh_name) for shape in link.visuals)
        element.extend(_shape("collision", shape, mesh_name) for shape in link.collisions)
    return element


def _shape(tag: str, shape: Shape, mesh_name: Namer) -> ElementTree.Element:
    element = ElementTree.Element(tag)
    element.append(_origin(shape.origin))
    geometry = ElementTree.SubElement(element, "geometry")
    if shape.kind == "mesh":
        assert shape.mesh is not None
        attributes = {"filename": mesh_name(shape.mesh), "scale": _numbers(shape.size)}
    elif shape.kind == "cylinder":
        attributes = {"radius": _numbers(shape.size[:1]), "length": _numbers(shape.size[1:])}
    else:
        attributes = {"size" if shape.kind == "box" else "radius": _numbers(shape.size)}
    ElementTree.SubElement(geometry, shape.kind, attributes)
    if shape.colour is not None and tag == "visual":
        name = "rgba_" + "_".join(f"{round(255 * c):02x}" for c in shape.colour)
        material = ElementTree.SubElement(element, "material", name=name)
        ElementTree.SubElement(material, "color", rgba=_numbers(shape.colour))
    return element


def _plain_kind(joint: Joint) -> str:
    return "prismatic" if joint.kind == "prismatic" else "revolute"


def _joint(joint: Joint, kind: str, coupled: bool, stands: float | None) -> ElementTree.Element:
    if stands is None and not joint.movable:
        stands = joint.lower
    fixed = stands is not None
    element = ElementTree.Element("joint", name=joint.name, type="fixed" if fixed else kind)
    motion = np.eye(4) if stands is None else joint_motion(joint, stands)
    element.append(_origin(joint.origin @ motion))
    ElementTree.SubElement(element, "parent", link=joint.parent)
    ElementTree.SubElement(element, "child", link=joint.child)
    if fixed:
        return element
    ElementTree.SubElement(element, "axis", xyz=_numbers(joint.axis))
    limits = {"lower": joint.lower, "upper": joint.upper}
    limits |= {"velocity": joint.velocity, "effort": joint.effort}
    # Parsers want finite numbers; a large one says "no limit" to all of them.
    limits = {key: min(max(value, -NO_LIMIT), NO_LIMIT) for key, value in limits.items()}
    ElementTree.SubElement(element, "limit", {k: _numbers((v,)) for k, v in limits.items()})
    if coupled and joint.mimic is not None:
        ElementTree.SubElement(
            element,
            "mimic",
            joint=joint.mimic.joint,
            multiplier=_numbers((joint.mimic.multiplier,)),
            offset=_numbers((joint.mimic.offset,)),
        )
    return element


def joint_motion(joint: Joint, position: float) -> Array:
    """Return the (4, 4) motion across a joint at a position in rad or m."""
    motion = np.eye(4)
    if joint.kind == "prismatic":
        motion[:3, 3] = position * joint.axis
    elif joint.kind in ("revolute", "continuous") and position != 0.0:
        motion[:3, :3] = matrix_from_axis_angle(joint.axis, position)
    return motion
