"""Compiled answers to "do these two shapes touch?": yes, no, or too close to call.

Spheres, cylinders and boxes are solid and convex. Every "no" rests on a direction along which
the shapes are at least `TOLERANCE` apart, every "yes" on a common point; whoever asks hands the
rest to an exact library. Shapes are rows of arrays, passed as arrays and row because views cost
more than the arithmetic: kind and size as in `robots.shapes`, and a pose of twelve numbers, the
rotation row by row and then the origin in m.

The separating axes of two boxes follow Gottschalk, Lin and Manocha, "OBBTree" (1996), the search
for cylinders Gilbert, Johnson and Keerthi, "A fast procedure for computing the distance between
complex objects in three-dimensional space" (1988), in its yes-or-no form.
"""

from __future__ import annotations

import math

import numpy as np

from robots.compiled import njit
from robots.shapes import CYLINDER, MESH, SPHERE
from robots.simplex import dot, evolve, minus

FREE, TOUCHING, UNSURE = range(3)
# Nearer to contact than this, in m, the exact library decides: its own tolerance.
TOLERANCE = 1e-6
# Steps of the search after which a pair counts as too close to call; most need fewer than ten.
STEPS = 64


@njit(_nrt=True)
def contact(kind, size, poses, a, b):  # type: ignore[no-untyped-def]
    """Whether two shapes touch.

    Args:
        kind: (S,) SPHERE, CYLINDER, BOX or MESH.
        size: (S, 3) m.
        poses: (S, 12) in any common frame, m.
        a: Row of the one shape.
        b: Row of the other.

    Returns:
        FREE, TOUCHING or UNSURE. A mesh is never touching: its bounding box is.
    """
    mesh = kind[a] == MESH or kind[b] == MESH
    if kind[a] == SPHERE:
        return _verdict(_gap_to_sphere(kind, size, poses, b, a), mesh)
    if kind[b] == SPHERE:
        return _verdict(_gap_to_sphere(kind, size, poses, a, b), mesh)
    gap = _gap_along_axes(kind, size, poses, a, b)
    if gap > TOLERANCE:
        return FREE
    if kind[a] != CYLINDER and kind[b] != CYLINDER:
        return _verdict(max(gap, _gap_along_edges(size, poses, a, b)), mesh)
    return UNSURE if mesh else _search(kind, size, poses, a, b)


@njit(no_cpython_wrapper=True)
def _verdict(gap, mesh):  # type: ignore[no-untyped-def]
    if gap > TOLERANCE:
        return FREE
    return UNSURE if mesh or gap > -TOLERANCE else TOUCHING


@njit(no_cpython_wrapper=True)
def into(poses, i, x, y, z):  # type: ignore[no-untyped-def]
    """Turn a vector of the common frame into the frame of shape i."""
    return (
        poses[i, 0] * x + poses[i, 3] * y + poses[i, 6] * z,
        poses[i, 1] * x + poses[i, 4] * y + poses[i, 7] * z,
        poses[i, 2] * x + poses[i, 5] * y + poses[i, 8] * z,
    )


@njit(no_cpython_wrapper=True)
def between(poses, a, b):  # type: ignore[no-untyped-def]
    """Vector from the origin of a to that of b."""
    return (
        poses[b, 9] - poses[a, 9],
        poses[b, 10] - poses[a, 10],
        poses[b, 11] - poses[a, 11],
    )


@njit(no_cpython_wrapper=True)
def _gap_to_sphere(kind, size, poses, a, sphere):  # type: ignore[no-untyped-def]
    """Distance between a shape and a sphere, m; anything negative when they overlap."""
    dx, dy, dz = between(poses, a, sphere)
    x, y, z = into(poses, a, dx, dy, dz)
    radius = size[sphere, 0]
    if kind[a] == SPHERE:
        return math.sqrt(x * x + y * y + z * z) - radius - size[a, 0]
    if kind[a] == CYLINDER:
        beside = max(math.sqrt(x * x + y * y) - size[a, 0], 0.0)
        above = max(abs(z) - size[a, 1], 0.0)
        return math.sqrt(beside * beside + above * above) - radius
    x = max(abs(x) - size[a, 0], 0.0)
    y = max(abs(y) - size[a, 1], 0.0)
    z = max(abs(z) - size[a, 2], 0.0)
    return math.sqrt(x * x + y * y + z * z) - radius


@njit(no_cpython_wrapper=True)
def extent(kind, size, poses, i, nx, ny, nz):  # type: ignore[no-untyped-def]
    """Half of a shape's extent along a unit direction, m."""
    x, y, z = into(poses, i, nx, ny, nz)
    if kind[i] == CYLINDER:
        return size[i, 0] * math.sqrt(x * x + y * y) + size[i, 1] * abs(z)
    return size[i, 0] * abs(x) + size[i, 1] * abs(y) + size[i, 2] * abs(z)


@njit(no_cpython_wrapper=True)
def _gap_along_axes(kind, size, poses, a, b):  # type: ignore[no-untyped-def]
    """Return a gap along the centres or the axes of either shape: a lower bound of distance, m.

    The first one above the tolerance, else the largest.
    """
    dx, dy, dz = between(poses, a, b)
    length = math.sqrt(dx * dx + dy * dy + dz * dz) + 1e-300
    nx, ny, nz = dx / length, dy / length, dz / length
    gap = length - extent(kind, size, poses, a, nx, ny, nz)
    gap -= extent(kind, size, poses, b, nx, ny, nz)
    for axis in range(6):
        if gap > TOLERANCE:
            return gap
        i, column = (a, axis) if axis < 3 else (b, axis - 3)
        nx, ny, nz = poses[i, column], poses[i, 3 + column], poses[i, 6 + column]
        reach = extent(kind, size, poses, a, nx, ny, nz)
        reach += extent(kind, size, poses, b, nx, ny, nz)
        gap = max(gap, abs(dx * nx + dy * ny + dz * nz) - reach)
    return gap


@njit(no_cpython_wrapper=True)
def _gap_along_edges(size, poses, a, b):  # type: ignore[no-untyped-def]
    """Return the largest gap of two boxes along the nine directions square to an edge of each, m.

    Together with the axes these are all that can separate two boxes.
    """
    dx, dy, dz = between(poses, a, b)
    gap = -np.inf
    for i in range(3):
        ux, uy, uz = poses[a, i], poses[a, 3 + i], poses[a, 6 + i]
        for j in range(3):
            vx, vy, vz = poses[b, j], poses[b, 3 + j], poses[b, 6 + j]
            nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
            length = math.sqrt(nx * nx + ny * ny + nz * nz)
            # Edges that are parallel to 1e-8 add nothing that the faces do not say to 1e-8.
            if length < 1e-8:
                continue
            reach = 0.0
            for s in (a, b):
                x, y, z = into(poses, s, nx, ny, nz)
                reach += size[s, 0] * abs(x) + size[s, 1] * abs(y) + size[s, 2] * abs(z)
            gap = max(gap, (abs(dx * nx + dy * ny + dz * nz) - reach) / length)
            if gap > TOLERANCE:
                return gap
    return gap


@njit(no_cpython_wrapper=True)
def support(kind, size, poses, i, n):  # type: ignore[no-untyped-def]
    """Return the point of a cylinder or box furthest along a direction of any length."""
    x, y, z = into(poses, i, n[0], n[1], n[2])
    if kind[i] == CYLINDER:
        across = math.sqrt(x * x + y * y)
        scale = size[i, 0] / across if across > 1e-12 * abs(z) else 0.0
        x, y, z = scale * x, scale * y, math.copysign(size[i, 1], z)
    else:
        x = math.copysign(size[i, 0], x)
        y = math.copysign(size[i, 1], y)
        z = math.copysign(size[i, 2], z)
    return (
        poses[i, 0] * x + poses[i, 1] * y + poses[i, 2] * z + poses[i, 9],
        poses[i, 3] * x + poses[i, 4] * y + poses[i, 5] * z + poses[i, 10],
        poses[i, 6] * x + poses[i, 7] * y + poses[i, 8] * z + poses[i, 11],
    )


@njit(no_cpython_wrapper=True)
def _search(kind, size, poses, a, b):  # type: ignore[no-untyped-def]
    """Search the difference of two cylinders or boxes for the origin, step by step."""
    simplex = np.empty((4, 3))
    count = 0
    # Towards the origin from where the search stands, at first from the centre of a - b.
    n = between(poses, a, b)
    if dot(n, n) < 1e-18:
        return TOUCHING
    for _ in range(STEPS):
        opposite = (-n[0], -n[1], -n[2])
        corner = minus(support(kind, size, poses, a, n), support(kind, size, poses, b, opposite))
        gap = -dot(corner, n) / math.sqrt(dot(n, n))
        if gap > TOLERANCE:
            return FREE
        if gap > -TOLERANCE:
            return UNSURE
        simplex[count, 0], simplex[count, 1], simplex[count, 2] = corner
        count, n, inside = evolve(simplex, count + 1)
        if inside:
            return TOUCHING
        # A direction of no length: the origin lies on the simplex, so at the border.
        if dot(n, n) < 1e-24:
            return UNSURE
    return UNSURE
