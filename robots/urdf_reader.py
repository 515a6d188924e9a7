"""Reading and checking URDF files, before any other parser sees them.

The C++ parsers behind Pinocchio and PyBullet print to stderr, guess or crash on malformed input.
Here every complaint is one sentence that names the file, what was expected and what came.
"""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robots.errors import UrdfError
from robots.meshes import resolve_mesh
from robots.rotations import matrix_from_rpy
from robots.urdf import JOINT_TYPES, MOVABLE, Inertial, Joint, Link, Mimic, Shape, Urdf
from robots.urdf_checks import check_mimics, check_tree, has_xacro, xacro_error

Array = NDArray[np.float64]


def read_urdf(path: str | Path) -> Urdf:
    """Parse and check a URDF file.

    Args:
        path: The file; meshes are looked for around it (see `robots.meshes`).

    Raises:
        UrdfError: With one sentence, if the file is missing, malformed or no kinematic tree.
    """
    path = Path(path)
    text = _read_text(path)
    root = _parse_xml(path, text)
    reader = _Reader(path)
    links = {link.name: link for link in map(reader.link, root.findall("link"))}
    joints = {joint.name: joint for joint in map(reader.joint, root.findall("joint"))}
    if len(links) < len(root.findall("link")) or len(joints) < len(root.findall("joint")):
        raise UrdfError(f"{path}: two links or two joints have the same name; names must differ")
    check_mimics(path, joints)
    return Urdf(
        name=root.get("name", path.stem),
        path=path,
        checksum=hashlib.sha256(text.encode()).hexdigest(),
        root=check_tree(path, links, joints),
        links=links,
        joints=joints,
        notes=tuple(reader.notes),
    )


def _read_text(path: Path) -> str:
    if path.is_dir():
        raise UrdfError(f"{path}: a folder, not a URDF file; give the file inside it")
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise UrdfError(f"{path}: no such file") from None
    except UnicodeDecodeError:
        raise UrdfError(f"{path}: not a text file, so not a URDF") from None
    except OSError as error:
        raise UrdfError(f"{path}: cannot be read: {error.strerror}") from None
    if not text.strip():
        raise UrdfError(f"{path}: the file is empty")
    return text


def _parse_xml(path: Path, text: str) -> ElementTree.Element:
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        # A macro without the declaration of its prefix is not even well-formed.
        if "<xacro:" in text:
            raise xacro_error(path) from None
        raise UrdfError(f"{path}: not well-formed XML: {error}") from None
    except ValueError as error:
        raise UrdfError(f"{path}: not readable as XML: {error}") from None
    if root.tag != "robot":
        raise UrdfError(f"{path}: the outermost element is <{root.tag}>, expected <robot>")
    if has_xacro(root):
        raise xacro_error(path)
    if root.find("link") is None:
        raise UrdfError(f"{path}: has no <link>, expected at least one")
    return root


class _Reader:
    """Turns XML elements into dataclasses, with the file's name in every complaint."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.notes: list[str] = []

    def link(self, element: ElementTree.Element) -> Link:
        name = self._attribute(element, "name", "a <link>")
        inertial = element.find("inertial")
        return Link(
            name=name,
            inertial=None if inertial is None else self._inertial(inertial, name),
            collisions=tuple(self._shape(e, name) for e in element.findall("collision")),
            visuals=tuple(self._shape(e, name) for e in element.findall("visual")),
        )

    def joint(self, element: ElementTree.Element) -> Joint:
        name = self._attribute(element, "name", "a <joint>")
        where = f"joint '{name}'"
        kind = self._attribute(element, "type", where)
        if kind not in JOINT_TYPES:
            raise UrdfError(
                f"{self.path}: {where} is of the unknown type '{kind}', expected one of "
                f"{', '.join(JOINT_TYPES)}"
            )
        lower, upper, velocity, effort = self._limits(element, kind, where)
        return Joint(
            name=name,
            kind=kind,
            parent=self._attribute(self._child(element, "parent", where), "link", where),
            child=self._attribute(self._child(element, "child", where), "link", where),
            origin=self._origin(element, where),
            axis=self._axis(element, kind, where),
            lower=lower,
            upper=upper,
            velocity=velocity,
            effort=effort,
            mimic=self._mimic(element, where),
        )

    def _limits(
        self, element: ElementTree.Element, kind: str, where: str
    ) -> tuple[float, float, float, float]:
        limit = element.find("limit")
        velocity = effort = float("inf")
        if limit is not None:
            velocity = self._numbers(limit.get("velocity", "0"), 1, where)[0] or float("inf")
            effort = self._numbers(limit.get("effort", "0"), 1, where)[0] or float("inf")
        if kind == "continuous":
            return -np.pi, np.pi, velocity, effort
        if kind not in MOVABLE:
            return 0.0, 0.0, velocity, effort
        if limit is None:
            raise UrdfError(f"{self.path}: {where} is {kind} and has no <limit>")
        lower = self._numbers(limit.get("lower", "0"), 1, f"the lower limit of {where}")[0]
        upper = self._numbers(limit.get("upper", "0"), 1, f"the upper limit of {where}")[0]
        if lower > upper:
            raise UrdfError(
                f"{self.path}: {where} has the lower limit {lower:g} above the upper {upper:g}"
            )
        if lower == upper:
            self.notes.append(
                f"{where} has limits of zero width and is treated as fixed at {lower:g}"
            )
        return lower, upper, velocity, effort

    def _axis(self, element: ElementTree.Element, kind: str, where: str) -> Array:
        tag = element.find("axis")
        text = "1 0 0" if tag is None else tag.get("xyz", "1 0 0")
        axis = np.array(self._numbers(text, 3, f"the axis of {where}"))
        length = float(np.linalg.norm(axis))
        if kind not in (*MOVABLE, "planar"):
            return np.array([1.0, 0.0, 0.0])
        if length < 1e-9:
            raise UrdfError(f"{self.path}: {where} has a zero axis, expected a direction")
        # Leave the many axes that are exact alone, to the last bit.
        return axis if length == 1.0 else axis / length

    def _mimic(self, element: ElementTree.Element, where: str) -> Mimic | None:
        mimic = element.find("mimic")
        if mimic is None:
            return None
        return Mimic(
            joint=self._attribute(mimic, "joint", where),
            multiplier=self._numbers(mimic.get("multiplier", "1"), 1, where)[0],
            offset=self._numbers(mimic.get("offset", "0"), 1, where)[0],
        )

    def _inertial(self, element: ElementTree.Element, link: str) -> Inertial:
        where = f"the inertial of link '{link}'"
        mass = self._child(element, "mass", where).get("value", "0")
        inertia = self._child(element, "inertia", where)
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        return Inertial(
            mass=self._numbers(mass, 1, where)[0],
            origin=self._origin(element, where),
            inertia=tuple(self._numbers(inertia.get(k, "0"), 1, where)[0] for k in keys),
        )

    def _shape(self, element: ElementTree.Element, link: str) -> Shape:
        where = f"the {element.tag} shape of link '{link}'"
        geometry = self._child(element, "geometry", where)
        origin = self._origin(element, where)
        colour = element.find("material/color")
        rgba = None if colour is None else self._numbers(colour.get("rgba", ""), 4, where)
        for kind, keys in (
            ("box", (("size", 3),)),
            ("cylinder", (("radius", 1), ("length", 1))),
            ("sphere", (("radius", 1),)),
        ):
            tag = geometry.find(kind)
            if tag is not None:
                size = sum((self._numbers(tag.get(k, ""), n, where) for k, n in keys), ())
                if min(size) < 0:
                    raise UrdfError(f"{self.path}: {where} has a negative size")
                return Shape(kind, size, origin, colour=rgba)
        tag = geometry.find("mesh")
        if tag is None:
            raise UrdfError(f"{self.path}: {where} is no box, cylinder, sphere or mesh")
        scale = self._numbers(tag.get("scale", "1 1 1"), 3, where)
        mesh = resolve_mesh(self._attribute(tag, "filename", where), self.path, where)
        return Shape("mesh", scale, origin, mesh=mesh, colour=rgba)

    def _origin(self, element: ElementTree.Element, where: str) -> Array:
        pose = np.eye(4)
        tag = element.find("origin")
        if tag is not None:
            pose[:3, 3] = self._numbers(tag.get("xyz", "0 0 0"), 3, f"the origin of {where}")
            rpy = self._numbers(tag.get("rpy", "0 0 0"), 3, f"the origin of {where}")
            pose[:3, :3] = matrix_from_rpy(rpy)
        return pose

    def _child(self, element: ElementTree.Element, tag: str, where: str) -> ElementTree.Element:
        child = element.find(tag)
        if child is None:
            raise UrdfError(f"{self.path}: {where} has no <{tag}>")
        return child

    def _attribute(self, element: ElementTree.Element, key: str, where: str) -> str:
        value = element.get(key)
        if not value:
            raise UrdfError(f"{self.path}: {where} has no {key}")
        return value

    def _numbers(self, text: str, count: int, where: str) -> tuple[float, ...]:
        try:
            values = tuple(float(word) for word in text.split())
        except ValueError:
            values = ()
        if len(values) != count or not np.isfinite(values).all():
            expected = "a finite number" if count == 1 else f"{count} finite numbers"
            raise UrdfError(f"{self.path}: {where} reads '{text}', expected {expected}")
        return values
