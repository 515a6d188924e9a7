"""Compiled collision queries for a whole robot, a batch at a time.

Per configuration: the frames of the driven joints, spheres around links, spheres around
shapes, and `robots.contact` for what is left.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robots.bodies import BodyTree
from robots.compiled import njit
from robots.contact import FREE, TOUCHING, UNSURE, contact
from robots.frames import multiplied, slid, turned
from robots.shapes import Shapes
from robots.trigonometry import sine_cosine

Array = NDArray[np.float64]
# A hair of room, in m, so that rounding never calls touching spheres apart.
SLACK = 1e-9
ROOT = np.array([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])


@njit(no_cpython_wrapper=True)
def read_frame(rows, i):  # type: ignore[no-untyped-def]
    """Row i of frames (m, 12) as a tuple."""
    a, b, c, d, e, f = rows[i, 0], rows[i, 1], rows[i, 2], rows[i, 3], rows[i, 4], rows[i, 5]
    g, h, k, x, y, z = rows[i, 6], rows[i, 7], rows[i, 8], rows[i, 9], rows[i, 10], rows[i, 11]
    return (a, b, c, d, e, f, g, h, k, x, y, z)


@njit(no_cpython_wrapper=True)
def write_frame(rows, i, frame):  # type: ignore[no-untyped-def]
    """Put a tuple into row i of frames (m, 12)."""
    for column in range(12):
        rows[i, column] = frame[column]


@njit(no_cpython_wrapper=True)
def find_frames(tree, q, frames):  # type: ignore[no-untyped-def]
    """Frames of the driven joints; row 0 is the root, row k + 1 is joint k."""
    driven = tree.driven
    for k in range(tree.parent.shape[0]):
        above = read_frame(frames, tree.parent[k] + 1)
        frame = multiplied(above, tree.rotations[k], tree.translations[k])
        position = driven.multiplier[k] * q[driven.variable[k]] + driven.offset[k]
        if driven.prismatic[k]:
            frame = slid(frame, position)
        else:
            sine, cosine = sine_cosine(position)
            frame = turned(frame, sine, cosine)
        write_frame(frames, k + 1, frame)


@njit(no_cpython_wrapper=True)
def carry(frames, owner, points, moved):  # type: ignore[no-untyped-def]
    """Points (K, 3) fixed in frames, carried to the root: (K, 3)."""
    for i in range(owner.shape[0]):
        a, b, c, d, e, f, g, h, k, x, y, z = read_frame(frames, owner[i] + 1)
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        moved[i, 0] = a * px + b * py + c * pz + x
        moved[i, 1] = d * px + e * py + f * pz + y
        moved[i, 2] = g * px + h * py + k * pz + z


@njit(no_cpython_wrapper=True)
def apart(points, a, others, b, reach):  # type: ignore[no-untyped-def]
    """Whether row a of points is further from row b of others than a reach from 0 [m]."""
    x, y, z = (
        points[a, 0] - others[b, 0],
        points[a, 1] - others[b, 1],
        points[a, 2] - others[b, 2],
    )
    return x * x + y * y + z * z > reach * reach


@njit(no_cpython_wrapper=True)
def turn(frames, owner, rotations, centres, poses, i):  # type: ignore[no-untyped-def]
    """Write the whole pose of shape i."""
    frame = multiplied(read_frame(frames, owner[i] + 1), rotations[i], rotations[i, 0])
    for column in range(9):
        poses[i, column] = frame[column]
    for column in range(3):
        poses[i, 9 + column] = centres[i, column]


@njit(nogil=True)
def query(tree, shapes, joints, verdicts, details):  # type: ignore[no-untyped-def]
    """Whether configurations are in collision, as far as it can be decided here.

    Args:
        tree: The `BodyTree`.
        shapes: The `Shapes`.
        joints: (N, dof), rad or m.
        verdicts: (N,) receives FREE, TOUCHING or UNSURE.
        details: (N, Q) receives the same for every pair of shapes, or (0, Q) if only the verdict
            is wanted; a configuration is then left as soon as it touches.
    """
    kind, size, owner, rotations = shapes.kind, shapes.size, shapes.frame, shapes.rotations
    radius, link_radius = shapes.radius, shapes.link_radius
    pair_links, start, pairs = shapes.pair_links, shapes.pair_start, shapes.pair_shapes
    frames = np.empty((tree.parent.shape[0] + 1, 12))
    write_frame(frames, 0, ROOT)
    link_centres = np.empty((link_radius.shape[0], 3))
    centres, poses = np.empty((kind.shape[0], 3)), np.empty((kind.shape[0], 12))
    # Which configuration the pose of a shape is of: most shapes never need theirs.
    stamps = np.full(kind.shape[0], -1)
    full = details.shape[0] > 0
    for i in range(joints.shape[0]):
        find_frames(tree, joints[i], frames)
        carry(frames, shapes.link_frame, shapes.link_centre, link_centres)
        carry(frames, owner, shapes.translations, centres)
        verdict = FREE
        for p in range(pair_links.shape[0]):
            a, b = pair_links[p, 0], pair_links[p, 1]
            if apart(link_centres, a, link_centres, b, link_radius[a] + link_radius[b] + SLACK):
                continue
            for s in range(start[p], start[p + 1]):
                a, b = pairs[s, 0], pairs[s, 1]
                if apart(centres, a, centres, b, radius[a] + radius[b] + SLACK):
                    continue
                for shape in (a, b):
                    if stamps[shape] != i:
                        stamps[shape] = i
                        turn(frames, owner, rotations, centres, poses, shape)
                state = contact(kind, size, poses, a, b)
                if full:
                    details[i, s] = state
                if state == TOUCHING or (state == UNSURE and verdict == FREE):
                    verdict = state
                if verdict == TOUCHING and not full:
                    break
            if verdict == TOUCHING and not full:
                break
        verdicts[i] = verdict


def verdicts(tree: BodyTree, shapes: Shapes, joints: Array) -> NDArray[np.int64]:
    """FREE, TOUCHING or UNSURE for each configuration, (N,) for (N, dof)."""
    result = np.empty(len(joints), dtype=np.int64)
    query(tree, shapes, joints, result, np.empty((0, len(shapes.pair_shapes)), dtype=np.int8))
    return result


def details(tree: BodyTree, shapes: Shapes, joints: Array) -> NDArray[np.int8]:
    """FREE, TOUCHING or UNSURE for each pair of shapes, (N, Q) for (N, dof)."""
    result = np.zeros((len(joints), len(shapes.pair_shapes)), dtype=np.int8)
    query(tree, shapes, joints, np.empty(len(joints), dtype=np.int64), result)
    return result
