"""Compiled signed distance of two shapes, with the direction and the place where it is taken.

Shapes are rows of arrays as in `robots.contact`. Spheres against anything are exact, inside too.
Boxes are exact: apart by corners against solids and edges against edges, overlapping by the least
overlap along the axes of Gottschalk, Lin and Manocha ("OBBTree", 1996), which is the depth. For
what is left (cylinders against boxes and cylinders; meshes count as their bounding boxes) the
largest gap along some axes is a lower bound of the distance.

The derivative of a signed distance is the normal times the relative velocity of the shapes at the
witness point (Ericson, "Real-Time Collision Detection", 2005, section 5.1, on closest points).
"""

from __future__ import annotations

import math

import numpy as np

from robots.compiled import njit
from robots.contact import between, extent, into, support
from robots.shapes import CYLINDER, SPHERE
from robots.simplex import minus

# Directions shorter than this, in m or as a sine, are none.
NO_LENGTH = 1e-9


@njit()
def find_gap(kind, size, poses, a, b):  # type: ignore[no-untyped-def]
    """Signed distance of two shapes.

    Arguments as of `robots.contact.contact`.

    Returns:
        Distance [m], below 0 the depth of the overlap; unit normal from a to b, a tuple; and the
        witness point, a tuple [m].
    """
    if kind[b] == SPHERE:
        return _gap_to_sphere(kind, size, poses, a, b)
    if kind[a] == SPHERE:
        distance, n, point = _gap_to_sphere(kind, size, poses, b, a)
        return distance, (-n[0], -n[1], -n[2]), point
    if kind[a] == CYLINDER or kind[b] == CYLINDER:
        return _gap_along_axes(kind, size, poses, a, b)
    distance, n, point = _gap_along_axes(kind, size, poses, a, b)
    if distance <= 0.0:
        return distance, n, point
    return _gap_of_boxes(size, poses, a, b, n, point)


@njit(no_cpython_wrapper=True)
def _gap_to_sphere(kind, size, poses, a, sphere):  # type: ignore[no-untyped-def]
    dx, dy, dz = between(poses, a, sphere)
    local = into(poses, a, dx, dy, dz)
    if kind[a] == SPHERE:
        distance, n = _from_point(local)
        distance -= size[a, 0]
    elif kind[a] == CYLINDER:
        distance, n = _from_cylinder(local, size[a, 0], size[a, 1])
    else:
        distance, n = _from_box(local, size[a, 0], size[a, 1], size[a, 2])
    centre = (poses[sphere, 9], poses[sphere, 10], poses[sphere, 11])
    return distance - size[sphere, 0], _out_of(poses, a, n), centre


@njit(no_cpython_wrapper=True)
def _from_point(p):  # type: ignore[no-untyped-def]
    length = math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
    if length < NO_LENGTH:
        return 0.0, (0.0, 0.0, 1.0)
    return length, (p[0] / length, p[1] / length, p[2] / length)


@njit(no_cpython_wrapper=True)
def _from_box(p, sx, sy, sz):  # type: ignore[no-untyped-def]
    """Signed distance of a point from a box in its frame, and the normal."""
    x, y, z = abs(p[0]) - sx, abs(p[1]) - sy, abs(p[2]) - sz
    ux, uy, uz = math.copysign(1.0, p[0]), math.copysign(1.0, p[1]), math.copysign(1.0, p[2])
    if x <= 0.0 and y <= 0.0 and z <= 0.0:
        if x >= y and x >= z:
            return x, (ux, 0.0, 0.0)
        if y >= z:
            return y, (0.0, uy, 0.0)
        return z, (0.0, 0.0, uz)
    return _from_point((ux * max(x, 0.0), uy * max(y, 0.0), uz * max(z, 0.0)))


@njit(no_cpython_wrapper=True)
def _from_cylinder(p, radius, half):  # type: ignore[no-untyped-def]
    """Signed distance of a point from a cylinder in its frame, and the normal."""
    across = math.sqrt(p[0] * p[0] + p[1] * p[1])
    ux, uy = (p[0] / across, p[1] / across) if across > NO_LENGTH else (1.0, 0.0)
    uz = math.copysign(1.0, p[2])
    beside, above = across - radius, abs(p[2]) - half
    if beside <= 0.0 and above <= 0.0:
        if beside >= above:
            return beside, (ux, uy, 0.0)
        return above, (0.0, 0.0, uz)
    beside, above = max(beside, 0.0), max(above, 0.0)
    return _from_point((ux * beside, uy * beside, uz * above))


@njit(no_cpython_wrapper=True)
def _out_of(poses, i, v):  # type: ignore[no-untyped-def]
    """Turn a vector of the frame of shape i into the common frame."""
    return (
        poses[i, 0] * v[0] + poses[i, 1] * v[1] + poses[i, 2] * v[2],
        poses[i, 3] * v[0] + poses[i, 4] * v[1] + poses[i, 5] * v[2],
        poses[i, 6] * v[0] + poses[i, 7] * v[1] + poses[i, 8] * v[2],
    )


@njit(no_cpython_wrapper=True)
def _axis(poses, a, b, number):  # type: ignore[no-untyped-def]
    """Direction to look for a gap: three axes of a, three of b, nine square to one of each."""
    if number < 6:
        i, column = (a, number) if number < 3 else (b, number - 3)
        return poses[i, column], poses[i, 3 + column], poses[i, 6 + column]
    i, j = (number - 6) // 3, (number - 6) % 3
    ux, uy, uz = poses[a, i], poses[a, 3 + i], poses[a, 6 + i]
    vx, vy, vz = poses[b, j], poses[b, 3 + j], poses[b, 6 + j]
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx


@njit(no_cpython_wrapper=True)
def _gap_along_axes(kind, size, poses, a, b):  # type: ignore[no-untyped-def]
    """Largest gap along fifteen axes, of which a cylinder's own are those that a box would have."""
    d = between(poses, a, b)
    best, chosen, n = -np.inf, 0, (0.0, 0.0, 1.0)
    for number in range(15):
        x, y, z = _axis(poses, a, b, number)
        length = math.sqrt(x * x + y * y + z * z)
        if length < NO_LENGTH:
            continue
        side = x * d[0] + y * d[1] + z * d[2]
        scale = math.copysign(1.0 / length, side)
        x, y, z = scale * x, scale * y, scale * z
        gap = abs(side) / length
        gap -= extent(kind, size, poses, a, x, y, z) + extent(kind, size, poses, b, x, y, z)
        # A hair more, so that of equal gaps the first one, of a face, is taken.
        if gap > best + NO_LENGTH:
            best, chosen, n = gap, number, (x, y, z)
    first = support(kind, size, poses, a, n)
    second = support(kind, size, poses, b, (-n[0], -n[1], -n[2]))
    if chosen < 3:
        return best, n, second
    if chosen < 6:
        return best, n, first
    return best, n, _middle(first, second)


@njit(no_cpython_wrapper=True)
def _middle(p, q):  # type: ignore[no-untyped-def]
    return ((p[0] + q[0]) / 2.0, (p[1] + q[1]) / 2.0, (p[2] + q[2]) / 2.0)


@njit(no_cpython_wrapper=True)
def _corner(size, poses, i, number):  # type: ignore[no-untyped-def]
    """One of the eight corners of box i."""
    x = size[i, 0] if number & 1 else -size[i, 0]
    y = size[i, 1] if number & 2 else -size[i, 1]
    z = size[i, 2] if number & 4 else -size[i, 2]
    v = _out_of(poses, i, (x, y, z))
    return (v[0] + poses[i, 9], v[1] + poses[i, 10], v[2] + poses[i, 11])


@njit(no_cpython_wrapper=True)
def _gap_of_boxes(size, poses, a, b, n, point):  # type: ignore[no-untyped-def]
    """Distance of two boxes that are apart; normal and point are kept where they touch."""
    best = np.inf
    for solid, other, sign in ((a, b, 1.0), (b, a, -1.0)):
        for number in range(8):
            p = _corner(size, poses, other, number)
            x, y, z = p[0] - poses[solid, 9], p[1] - poses[solid, 10], p[2] - poses[solid, 11]
            local = into(poses, solid, x, y, z)
            distance, u = _from_box(local, size[solid, 0], size[solid, 1], size[solid, 2])
            if NO_LENGTH < distance < best:
                v = _out_of(poses, solid, u)
                best, n, point = distance, (sign * v[0], sign * v[1], sign * v[2]), p
    for first in range(12):
        edge = _edge(size, poses, a, first)
        for second in range(12):
            distance, u, p = _gap_of_edges(edge, _edge(size, poses, b, second))
            if NO_LENGTH < distance < best:
                best, n, point = distance, u, p
    return (best if best < np.inf else 0.0), n, point


@njit(no_cpython_wrapper=True)
def _edge(size, poses, i, number):  # type: ignore[no-untyped-def]
    """Middle, unit direction and half length of one of the twelve edges of box i."""
    axis, signs = number // 4, number % 4
    x, y, z = size[i, 0], size[i, 1], size[i, 2]
    first, second = (1.0 if signs & 1 else -1.0), (1.0 if signs & 2 else -1.0)
    if axis == 0:
        v = (0.0, first * y, second * z)
    elif axis == 1:
        v = (first * x, 0.0, second * z)
    else:
        v = (first * x, second * y, 0.0)
    v = _out_of(poses, i, v)
    middle = (v[0] + poses[i, 9], v[1] + poses[i, 10], v[2] + poses[i, 11])
    return middle, (poses[i, axis], poses[i, 3 + axis], poses[i, 6 + axis]), size[i, axis]


@njit(no_cpython_wrapper=True)
def _gap_of_edges(first, second):  # type: ignore[no-untyped-def]
    """Distance of two edges, each as of `_edge`, where it is taken inside both, else infinite.

    Two lines at their nearest: Ericson, "Real-Time Collision Detection", section 5.1.8.
    """
    p, u, half_u = first
    q, v, half_v = second
    cosine = u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
    sine2 = 1.0 - cosine * cosine
    if sine2 < NO_LENGTH:
        return np.inf, u, p
    w = minus(p, q)
    along_u = u[0] * w[0] + u[1] * w[1] + u[2] * w[2]
    along_v = v[0] * w[0] + v[1] * w[1] + v[2] * w[2]
    s = (cosine * along_v - along_u) / sine2
    t = (along_v - cosine * along_u) / sine2
    if abs(s) > half_u or abs(t) > half_v:
        return np.inf, u, p
    near = (p[0] + s * u[0], p[1] + s * u[1], p[2] + s * u[2])
    far = (q[0] + t * v[0], q[1] + t * v[1], q[2] + t * v[2])
    distance, n = _from_point(minus(far, near))
    return distance, n, near
