"""What a URDF says: a tree of links and joints with their shapes, masses and limits.

`robots.urdf_reader` makes these plain dataclasses from a file, and other libraries only ever get
XML that `robots.urdf_writer` made from them.
"""

from __future__ import annotations

import difflib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robots.errors import UrdfError

Array = NDArray[np.float64]

MOVABLE = ("revolute", "continuous", "prismatic")
JOINT_TYPES = (*MOVABLE, "fixed", "floating", "planar")


@dataclass(frozen=True)
class Shape:
    """A collision or visual shape in the frame of its link.

    Attributes:
        kind: box, cylinder, sphere or mesh.
        size: box: the three edges; cylinder: radius, length along z; sphere: radius; mesh: the
            three scale factors. Metres but for the scale.
        origin: (4, 4) pose in the link frame, metres.
        mesh: the mesh file, for the kind mesh only.
        colour: red, green, blue, alpha of 0 to 1, if the file gives one.
    """

    kind: str
    size: tuple[float, ...]
    origin: Array
    mesh: Path | None = None
    colour: tuple[float, ...] | None = None


@dataclass(frozen=True)
class Inertial:
    """Mass in kg, pose of the inertia frame (4, 4) in m, and ixx ixy ixz iyy iyz izz in kg m^2."""

    mass: float
    origin: Array
    inertia: tuple[float, ...]


@dataclass(frozen=True)
class Link:
    """A rigid body."""

    name: str
    inertial: Inertial | None
    collisions: tuple[Shape, ...]
    visuals: tuple[Shape, ...]


@dataclass(frozen=True)
class Mimic:
    """A coupled joint: position = multiplier x (position of `joint`) + offset."""

    joint: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class Joint:
    """A joint; angles in rad, lengths in m.

    Attributes:
        origin: (4, 4) pose of the joint in the frame of the parent link.
        axis: (3,) unit vector in the joint frame.
        lower: limit, -pi for a continuous joint, which stands for all turns; -inf where a coupled
            joint has none.
        upper: limit, +pi for a continuous joint; +inf where a coupled joint has none.
        velocity: limit in rad/s or m/s, infinite where the file gives none.
        effort: limit in Nm or N, infinite where the file gives none.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Array
    axis: Array
    lower: float = 0.0
    upper: float = 0.0
    velocity: float = float("inf")
    effort: float = float("inf")
    mimic: Mimic | None = None

    @property
    def movable(self) -> bool:
        """Whether the joint has one degree of freedom and room to use it."""
        return self.kind in MOVABLE and self.upper > self.lower

    @property
    def endless(self) -> bool:
        """Whether the joint turns for ever, so that full turns make no difference."""
        return self.kind == "continuous"


@dataclass(frozen=True)
class Urdf:
    """A checked URDF: a tree of links and joints.

    Attributes:
        notes: what was odd but could be dealt with, one sentence each.
        broken_collisions: collision shapes that cannot be used, one sentence each.
        broken_visuals: visual shapes that cannot be used, one sentence each.
        broken_mimics: joints whose coupling leads nowhere, with one sentence each.
        checksum: sha256 of the file, hexadecimal.
    """

    name: str
    path: Path
    checksum: str
    root: str
    links: dict[str, Link]
    joints: dict[str, Joint]
    notes: tuple[str, ...] = field(default=())
    broken_collisions: tuple[str, ...] = field(default=())
    broken_visuals: tuple[str, ...] = field(default=())
    broken_mimics: dict[str, str] = field(default_factory=dict)

    def require_shapes(self, kind: str) -> None:
        """Make sure that every shape of a kind can be used, before somebody relies on them.

        Args:
            kind: "collision" or "visual".

        Raises:
            UrdfError: One cannot; kinematics does without.
        """
        broken = self.broken_collisions if kind == "collision" else self.broken_visuals
        if broken:
            more = f" (and {len(broken) - 1} more like it)" if len(broken) > 1 else ""
            raise UrdfError(f"{self.path}: {broken[0]}{more}")

    def parent_joint(self, link: str) -> Joint | None:
        """Return the joint that carries a link, or nothing for the root."""
        return self._carriers.get(link)

    def links_above(self, link: str) -> list[str]:
        """Links from the parent of a link up to the root; none if there is no such link."""
        above = []
        while (joint := self.parent_joint(link)) is not None:
            link = joint.parent
            above.append(link)
        return above

    def path_between(self, base: str, tip: str) -> list[Joint]:
        """Joints from base to tip.

        Raises:
            UrdfError: If a link does not exist or the tip does not hang below the base.
        """
        for role, link in (("base", base), ("tip", tip)):
            if link not in self.links:
                near = difflib.get_close_matches(link, self.links, n=5, cutoff=0.3)
                raise UrdfError(
                    f"{self.path}: no link '{link}' to be the {role}; the nearest of its "
                    f"{len(self.links)} links are {', '.join(near or list(self.links)[:5])}"
                )
        joints: list[Joint] = []
        link = tip
        while link != base:
            joint = self.parent_joint(link)
            if joint is None:
                raise UrdfError(
                    f"{self.path}: the tip '{tip}' is not below the base '{base}'; above it are "
                    f"{', '.join(j.parent for j in joints) or 'no links'}"
                )
            joints.append(joint)
            link = joint.parent
        return joints[::-1]

    @property
    def _carriers(self) -> dict[str, Joint]:
        if "carriers" not in self.__dict__:
            # A frozen dataclass may still cache what follows from its fields.
            self.__dict__["carriers"] = {joint.child: joint for joint in self.joints.values()}
        carriers: dict[str, Joint] = self.__dict__["carriers"]
        return carriers
