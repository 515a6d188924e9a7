"""Collision shapes of a robot and the pairs to check, as plain arrays for compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.bodies import Bodies
from robots.urdf import Shape, Urdf

Array = NDArray[np.float64]

SPHERE, CYLINDER, BOX, MESH = range(4)


class Shapes(NamedTuple):
    """All collision shapes, link by link.

    Attributes:
        kind: (S,) SPHERE, CYLINDER, BOX or MESH.
        size: (S, 3) in m. Sphere: radius. Cylinder: radius, half of the length. Box: half edges.
            Mesh: half edges of its bounding box, whose centre counts as the mesh's origin.
        frame: (S,) frame of the shape (see `robots.bodies`).
        rotations: (S, 3, 3) and
        translations: (S, 3) of the shape in its frame, m.
        radius: (S,) of the sphere around the origin that holds the shape, m.
        link_frame: (L,) frame of each link that has shapes.
        link_centre: (L, 3) and
        link_radius: (L,) of a sphere that holds all shapes of a link, in its frame, m.
        link_start: (L + 1,) where the shapes of each link begin.
        pair_links: (P, 2) pairs of links to check.
        pair_start: (P + 1,) where each pair of links begins in
        pair_shapes: (Q, 2) pairs of shapes.
    """

    kind: NDArray[np.int64]
    size: Array
    frame: NDArray[np.int64]
    rotations: Array
    translations: Array
    radius: Array
    link_frame: NDArray[np.int64]
    link_centre: Array
    link_radius: Array
    link_start: NDArray[np.int64]
    pair_links: NDArray[np.int64]
    pair_start: NDArray[np.int64]
    pair_shapes: NDArray[np.int64]


def build_shapes(
    urdf: Urdf,
    bodies: Bodies,
    pairs: Sequence[tuple[str, str]],
    mesh_boxes: dict[str, Any],
    further: Sequence[str] = (),
) -> Shapes:
    """Collect the shapes of the links that occur in the pairs.

    Args:
        urdf: The robot.
        bodies: Its links.
        pairs: Pairs of links to check.
        mesh_boxes: Corners (2, 3) of the bounding box of each mesh in its own frame, m, under
            the name `<link>_<number of the shape>`.
        further: Links with shapes that are collected as well.
    """
    links = list(dict.fromkeys([*(link for pair in pairs for link in pair), *further]))
    rows: list[tuple[int, Array, int, Array]] = []
    members: dict[str, list[int]] = {}
    for link in links:
        for number, shape in enumerate(urdf.links[link].collisions):
            members.setdefault(link, []).append(len(rows))
            kind, size, shift = _core(shape, mesh_boxes.get(f"{link}_{number}"))
            pose = bodies.pose[link] @ shape.origin @ shift
            rows.append((kind, size, bodies.frame[link], pose))
    kinds = np.array([row[0] for row in rows], dtype=np.int64)
    sizes = np.array([row[1] for row in rows]).reshape(-1, 3)
    poses = np.array([row[3] for row in rows]).reshape(-1, 4, 4)
    radius = _radius(kinds, sizes)
    spheres = [_sphere(poses[members[link], :3, 3], radius[members[link]]) for link in links]
    by_shape = [
        [(a, b) for a in members[first] for b in members[second]] for first, second in pairs
    ]
    return Shapes(
        kind=kinds,
        size=sizes,
        frame=np.array([row[2] for row in rows], dtype=np.int64),
        rotations=np.ascontiguousarray(poses[:, :3, :3]),
        translations=np.ascontiguousarray(poses[:, :3, 3]),
        radius=radius,
        link_frame=np.array([bodies.frame[link] for link in links], dtype=np.int64),
        link_centre=np.array([centre for centre, _ in spheres]).reshape(-1, 3),
        link_radius=np.array([r for _, r in spheres]),
        link_start=np.cumsum([0, *(len(members[link]) for link in links)], dtype=np.int64),
        pair_links=np.array(
            [(links.index(a), links.index(b)) for a, b in pairs], dtype=np.int64
        ).reshape(-1, 2),
        pair_start=np.cumsum([0, *map(len, by_shape)], dtype=np.int64),
        pair_shapes=np.array(
            [pair for group in by_shape for pair in group], dtype=np.int64
        ).reshape(-1, 2),
    )


def _core(shape: Shape, mesh_box: Array | None) -> tuple[int, Array, Array]:
    """Kind, size and the pose of the centre in the frame of the shape."""
    shift = np.eye(4)
    if shape.kind == "sphere":
        return SPHERE, np.array([shape.size[0], 0.0, 0.0]), shift
    if shape.kind == "cylinder":
        return CYLINDER, np.array([shape.size[0], shape.size[1] / 2, 0.0]), shift
    if shape.kind == "box":
        return BOX, np.array(shape.size) / 2, shift
    assert mesh_box is not None
    shift[:3, 3] = (mesh_box[0] + mesh_box[1]) / 2
    return MESH, (mesh_box[1] - mesh_box[0]) / 2, shift


def _radius(kinds: NDArray[np.int64], sizes: Array) -> Array:
    cylinder = np.hypot(sizes[:, 0], sizes[:, 1])
    box = np.linalg.norm(sizes, axis=1)
    return np.select([kinds == SPHERE, kinds == CYLINDER], [sizes[:, 0], cylinder], box)


def _sphere(centres: Array, radius: Array) -> tuple[Array, float]:
    """Return a small sphere around spheres: a few steps towards the furthest one.

    Badoiu and Clarkson, "Smaller core-sets for balls", 2003.
    """
    centre = centres.mean(axis=0)
    for step in range(1, 200):
        reach = np.linalg.norm(centres - centre, axis=1) + radius
        furthest = int(np.argmax(reach))
        direction = centres[furthest] - centre
        length = float(np.linalg.norm(direction))
        if length == 0.0:
            break
        centre = centre + direction / length * min(length, reach[furthest] / (step + 1))
    return centre, float((np.linalg.norm(centres - centre, axis=1) + radius).max())
