"""Shapes of a robot as triangles, gathered by what moves together; needs trimesh (extra `view`)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from robots.urdf import Shape

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
Colour = tuple[int, int, int]
Kind = Literal["visual", "collision"]
GREY: Colour = (178, 186, 194)  # where the description gives no colour
SHARP_RAD = 0.7  # edges between faces that turn by more are seen as edges


@dataclass(frozen=True)
class Part:
    """Triangles of one colour that move with one link.

    Attributes:
        link: Whose frame they are in.
        vertices: (V, 3) [m].
        faces: (F, 3) rows of `vertices`.
        colour: Red, green, blue, 0 to 255.
    """

    link: str
    vertices: Array
    faces: NDArray[np.int64]
    colour: Colour


def moving_links(robot: Robot) -> dict[str, tuple[str, Array]]:
    """For every link one that it is rigidly connected with, and its pose (4, 4) in its frame.

    With the hand open all links of a frame are one body: a few nodes of a scene in place of many.
    """
    bodies = robot.bodies
    anchors: dict[int, str] = {}
    for link, frame in bodies.frame.items():
        anchors.setdefault(frame, link)
    return {
        link: (
            anchors[frame],
            np.linalg.inv(bodies.pose[anchors[frame]]) @ bodies.pose[link],
        )
        for link, frame in bodies.frame.items()
    }


def single_links(robot: Robot) -> dict[str, tuple[str, Array]]:
    """Every link for itself, as where fingers move."""
    return {link: (link, np.eye(4)) for link in robot.urdf.links}


def parts_of(
    robot: Robot, kind: Kind, carriers: Mapping[str, tuple[str, Array]], one_colour: bool = False
) -> list[Part]:
    """The shapes of a robot as triangles, one part for each carrier and colour.

    Args:
        robot: The robot.
        kind: Of the shapes.
        carriers: For each link the one whose part it is in, and its pose there.
        one_colour: Whether colours do not matter.

    Raises:
        UrdfError: A mesh cannot be used.
    """
    robot.urdf.require_shapes(kind)
    placed: dict[str, list[Shape]] = defaultdict(list)
    for name, link in robot.urdf.links.items():
        carrier, pose = carriers[name]
        for shape in link.visuals if kind == "visual" else link.collisions:
            colour = None if one_colour else shape.colour
            placed[carrier].append(replace(shape, origin=pose @ shape.origin, colour=colour))
    return [part for link, shapes in placed.items() for part in parts_of_shapes(link, shapes)]


def parts_of_shapes(link: str, shapes: Iterable[Shape]) -> list[Part]:
    """Shapes as triangles, one part for each colour.

    Args:
        link: What the parts are said to move with.
        shapes: In the frame of that.
    """
    import trimesh

    found: dict[Colour, list[Any]] = defaultdict(list)
    for shape in shapes:
        mesh = shape_mesh(shape)
        mesh.apply_transform(shape.origin)
        found[_colour(shape)].append(mesh)
    return [
        Part(link, *_triangles(trimesh.util.concatenate(meshes)), colour)
        for colour, meshes in found.items()
    ]


def shape_mesh(shape: Shape) -> Any:
    """A shape of a URDF in its own frame [m], as trimesh has it."""
    from trimesh import creation, load_mesh

    if shape.kind == "box":
        return creation.box(extents=shape.size)
    if shape.kind == "cylinder":
        return creation.cylinder(radius=shape.size[0], height=shape.size[1], sections=28)
    if shape.kind == "sphere":
        return creation.uv_sphere(radius=shape.size[0], count=(14, 20))
    mesh = load_mesh(shape.mesh)
    mesh.apply_scale(shape.size)
    return mesh


def _colour(shape: Shape) -> Colour:
    if shape.colour is None:
        return GREY
    red, green, blue = (round(255 * share) for share in shape.colour[:3])
    return red, green, blue


def _triangles(mesh: Any) -> tuple[Array, NDArray[np.int64]]:
    """Vertices and faces, vertices split at sharp edges so that each side is lit by itself."""
    from trimesh.graph import smooth_shade

    split = smooth_shade(mesh, angle=SHARP_RAD)
    return np.asarray(split.vertices, dtype=np.float64), np.asarray(split.faces, dtype=np.int64)


def inset(part: Part, depth: float) -> Part:
    """A part whose surface lies deeper, so that it vanishes in its like and does not flicker there.

    Args:
        part: What to shrink.
        depth: Along the normals [m].
    """
    a, b, c = (part.vertices[part.faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    normals = np.zeros_like(part.vertices)
    for corner in range(3):
        np.add.at(normals, part.faces[:, corner], across)
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    return replace(part, vertices=part.vertices - depth * normals / np.maximum(lengths, 1e-12))


def floor_height(parts: list[Part], poses: Mapping[str, Array]) -> float:
    """Height of the lowest point of a robot [m].

    Args:
        parts: Its shapes.
        poses: Pose (4, 4) of each link in the root's frame.
    """
    lows = [
        (part.vertices @ poses[part.link][:3, :3].T + poses[part.link][:3, 3])[:, 2].min()
        for part in parts
    ]
    return float(min(lows, default=0.0))
