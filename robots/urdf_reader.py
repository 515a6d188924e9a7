"""Reading and checking URDF files, before any other parser sees them.

The C++ parsers behind Pinocchio and PyBullet print to stderr, guess or crash on malformed input.
Here every complaint is one sentence that names the file, what was expected and what came. What
kinematics does not need (shapes, colours, inertia) never refuses a robot: it becomes a note, and
an error only where shapes are wanted.
"""

from __future__ import annotations

import hashlib
import math
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from robots.errors import UrdfError
from robots.meshes import resolve_mesh
from robots.rotations import matrix_from_rpy
from robots.urdf import JOINT_TYPES, MOVABLE, Inertial, Joint, Link, Mimic, Shape, Urdf
from robots.urdf_checks import broken_mimics, check_tree
from robots.urdf_xml import read_document

Array = NDArray[np.float64]
Colour = tuple[float, ...]
Part = TypeVar("Part", Link, Joint)

# Wider limits of a turning joint say "for ever": no cable bears them, and sines lose digits.
ENDLESS_RAD = 1000.0
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII)
_INFINITE = {"inf": math.inf, "infinity": math.inf}


def read_urdf(path: str | Path) -> Urdf:
    """Parse and check a URDF file.

    Args:
        path: The file; meshes are looked for around it (see `robots.meshes`).

    Raises:
        UrdfError: With one sentence, if the file is missing, malformed or no kinematic tree.
    """
    if not isinstance(path, str | Path):
        raise UrdfError(f"expected the path of a URDF file, got {type(path).__name__}")
    if "<robot" in str(path):
        raise UrdfError("expected the path of a URDF file, got the text of one: save it first")
    path = Path(path)
    document = read_document(path)
    reader = _Reader(path, document.root)
    links = _by_name(path, map(reader.link, document.root.findall("link")))
    joints = _by_name(path, map(reader.joint, document.root.findall("joint")))
    broken = broken_mimics(joints)
    for joint in broken:
        joints[joint] = replace(joints[joint], mimic=None)
    reader.notes += [f"{why}: it stands still" for why in broken.values()]
    return Urdf(
        name=document.root.get("name", "").strip() or path.stem,
        path=path,
        checksum=hashlib.sha256(document.text.encode()).hexdigest(),
        root=check_tree(path, links, joints),
        links=links,
        joints=joints,
        notes=(*document.notes, *reader.notes),
        broken_collisions=tuple(reader.broken["collision"]),
        broken_visuals=tuple(reader.broken["visual"]),
        broken_mimics=broken,
    )


def _by_name(path: Path, parts: Iterable[Part]) -> dict[str, Part]:
    named: dict[str, Part] = {}
    for part in parts:
        if part.name in named:
            kind = type(part).__name__.lower()
            raise UrdfError(f"{path}: two {kind}s have the same name '{part.name}'; names differ")
        named[part.name] = part
    return named


class _Reader:
    """Turns XML elements into dataclasses, with the file's name in every complaint."""

    def __init__(self, path: Path, root: ElementTree.Element) -> None:
        self.path = path
        self.notes: list[str] = []
        self.broken: dict[str, list[str]] = {"collision": [], "visual": []}
        self.materials = self._materials(root)

    def link(self, element: ElementTree.Element) -> Link:
        name = self._attribute(element, "name", "a <link>")
        return Link(
            name=name,
            inertial=self._inertial(element.find("inertial"), name),
            collisions=self._shapes(element, "collision", name),
            visuals=self._shapes(element, "visual", name),
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
        mimic = self._mimic(element, where)
        kind, lower, upper = self._limits(element, kind, mimic is not None, where)
        return Joint(
            name=name,
            kind=kind,
            parent=self._attribute(self._child(element, "parent", where), "link", where),
            child=self._attribute(self._child(element, "child", where), "link", where),
            origin=self._origin(element, where),
            axis=self._axis(element, kind, where),
            lower=lower,
            upper=upper,
            velocity=self._capacity(element, "velocity", where),
            effort=self._capacity(element, "effort", where),
            mimic=mimic,
        )

    def _limits(
        self, element: ElementTree.Element, kind: str, coupled: bool, where: str
    ) -> tuple[str, float, float]:
        """Kind and limits of a joint; a turning one whose limits are no limits is continuous."""
        if kind == "continuous":
            return kind, -np.pi, np.pi
        if kind not in MOVABLE:
            return kind, 0.0, 0.0
        limit = element.find("limit")
        if limit is None and not coupled:
            raise UrdfError(f"{self.path}: {where} is {kind} and has no <limit>")
        given = {} if limit is None else limit.attrib
        lower = self._limit(given.get("lower", "0"), f"the lower limit of {where}")
        upper = self._limit(given.get("upper", "0"), f"the upper limit of {where}")
        if lower > upper:
            raise UrdfError(
                f"{self.path}: {where} has the lower limit {lower:g} above the upper {upper:g}"
            )
        if coupled:  # it stands where its master puts it, so a range of zero width is none
            return (kind, lower, upper) if lower < upper else (kind, -math.inf, math.inf)
        if kind == "revolute" and upper - lower > ENDLESS_RAD:
            self.notes.append(
                f"{where} has limits of {lower:g} to {upper:g} rad and is treated as continuous"
            )
            return "continuous", -np.pi, np.pi
        if lower == upper:
            self.notes.append(
                f"{where} has limits of zero width and is treated as fixed at {lower:g}"
            )
        return kind, lower, upper

    def _limit(self, text: str, where: str) -> float:
        word = text.strip().lower()
        if (size := _INFINITE.get(word.lstrip("+-"))) is not None:
            return -size if word.startswith("-") else size
        if _NUMBER.fullmatch(word) and math.isinf(float(word)):
            return float(word)
        return self._numbers(text, 1, where)[0]

    def _capacity(self, element: ElementTree.Element, key: str, where: str) -> float:
        """Velocity or effort limit, infinite where there is none or none that can be read."""
        limit = element.find("limit")
        text = "0" if limit is None else limit.get(key, "0")
        try:
            value = self._limit(text, where)
        except UrdfError:
            self.notes.append(f"the {key} limit of {where} reads '{text}' and counts as none")
            return math.inf
        return value if value > 0.0 else math.inf

    def _axis(self, element: ElementTree.Element, kind: str, where: str) -> Array:
        if kind not in (*MOVABLE, "planar"):
            return np.array([1.0, 0.0, 0.0])
        tag = element.find("axis")
        text = "1 0 0" if tag is None else tag.get("xyz", "1 0 0")
        axis = np.array(self._numbers(text, 3, f"the axis of {where}"))
        largest = float(np.abs(axis).max())
        if largest < 1e-9:
            raise UrdfError(f"{self.path}: {where} has a zero axis, expected a direction")
        if largest > 1e100:  # the squares of such numbers overflow
            axis = axis / largest
        length = float(np.linalg.norm(axis))
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

    def _inertial(self, element: ElementTree.Element | None, link: str) -> Inertial | None:
        if element is None:
            return None
        where = f"the inertial of link '{link}'"
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        try:
            mass = self._child(element, "mass", where).get("value", "0")
            inertia = self._child(element, "inertia", where)
            return Inertial(
                mass=self._numbers(mass, 1, where)[0],
                origin=self._origin(element, where),
                inertia=tuple(self._numbers(inertia.get(k, "0"), 1, where)[0] for k in keys),
            )
        except UrdfError as error:
            self.notes.append(f"{self._problem(error)}, so the link counts as without inertia")
            return None

    def _shapes(self, element: ElementTree.Element, tag: str, link: str) -> tuple[Shape, ...]:
        """Shapes of a link; those that cannot be used are set down in `broken` and in `notes`."""
        shapes: list[Shape] = []
        for shape in element.findall(tag):
            try:
                shapes += self._shape(shape, f"the {tag} shape of link '{link}'")
            except UrdfError as error:
                problem = self._problem(error)
                self.broken[tag].append(problem)
                self.notes.append(f"{problem}: kinematics goes without it")
        return tuple(shapes)

    def _problem(self, error: UrdfError) -> str:
        return str(error).removeprefix(f"{self.path}: ")

    def _shape(self, element: ElementTree.Element, where: str) -> list[Shape]:
        geometry = self._child(element, "geometry", where)
        origin = self._origin(element, where)
        colour = self._colour(element, where) if element.tag == "visual" else None
        for kind, keys in (
            ("box", (("size", 3),)),
            ("cylinder", (("radius", 1), ("length", 1))),
            ("sphere", (("radius", 1),)),
            ("capsule", (("radius", 1), ("length", 1))),
        ):
            tag = geometry.find(kind)
            if tag is not None:
                size = sum((self._numbers(tag.get(k, ""), n, where) for k, n in keys), ())
                if min(size) < 0:
                    raise UrdfError(f"{self.path}: {where} has a negative size")
                if kind == "capsule":
                    return _capsule(size, origin, colour)
                return [Shape(kind, size, origin, colour=colour)]
        tag = geometry.find("mesh")
        if tag is None:
            found = ", ".join(f"<{child.tag}>" for child in geometry) or "nothing"
            raise UrdfError(
                f"{self.path}: {where} is no box, cylinder, sphere, capsule or mesh, but {found}"
            )
        scale = self._numbers(tag.get("scale", "1 1 1"), 3, where)
        mesh = resolve_mesh(self._attribute(tag, "filename", where), self.path, where)
        return [Shape("mesh", scale, origin, mesh=mesh, colour=colour)]

    def _materials(self, root: ElementTree.Element) -> dict[str, Colour]:
        """Colours by name of material; one that a link defines is known to all others."""
        colours: dict[str, Colour] = {}
        for material in (*root.findall("material"), *root.findall("link/visual/material")):
            name, colour = material.get("name"), material.find("color")
            if name and colour is not None:
                rgba = self._rgba(colour)
                if rgba is not None:
                    colours.setdefault(name, rgba)
        return colours

    def _colour(self, element: ElementTree.Element, where: str) -> Colour | None:
        """The shape's own colour, else that of the material it names, else none."""
        material = element.find("material")
        if material is None:
            return None
        colour = material.find("color")
        if colour is not None:
            rgba = self._rgba(colour)
            if rgba is not None:
                return rgba
            self.notes.append(
                f"{where} has the colour '{colour.get('rgba', '')}', expected four numbers of 0 "
                f"to 1: it is drawn without"
            )
        return self.materials.get(material.get("name", ""))

    def _rgba(self, colour: ElementTree.Element) -> Colour | None:
        try:
            rgba = self._numbers(colour.get("rgba", ""), 4, "a colour")
        except UrdfError:
            return None
        return rgba if min(rgba) >= 0.0 and max(rgba) <= 1.0 else None

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
        words = text.split()
        # Not everything that Python reads as a number is one in a URDF: 2_5, nan, other digits.
        values = tuple(float(word) for word in words if _NUMBER.fullmatch(word))
        if not len(words) == len(values) == count or not np.isfinite(values).all():
            expected = "a finite number" if count == 1 else f"{count} finite numbers"
            raise UrdfError(f"{self.path}: {where} reads '{text}', expected {expected}")
        return values


def _capsule(size: tuple[float, ...], origin: Array, colour: Colour | None) -> list[Shape]:
    """A capsule along z (radius, length between the centres of its ends) as what it is made of."""
    radius, length = size
    ends = []
    for side in (-0.5, 0.5):
        shift = np.eye(4)
        shift[2, 3] = side * length
        ends.append(Shape("sphere", (radius,), origin @ shift, colour=colour))
    return [Shape("cylinder", size, origin, colour=colour), *ends]
