"""The simplex of the Gilbert-Johnson-Keerthi search, in compiled code.

Which corners of a point, edge, triangle or tetrahedron are nearest to the origin, and which way
the origin lies from there. Corners are rows of an array, the newest one last.
"""

from __future__ import annotations

from robots.compiled import njit


@njit(no_cpython_wrapper=True)
def dot(a, b):  # type: ignore[no-untyped-def]
    """Inner product of two tuples of three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(no_cpython_wrapper=True)
def cross(a, b):  # type: ignore[no-untyped-def]
    """Vector product of two tuples of three."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@njit(no_cpython_wrapper=True)
def minus(a, b):  # type: ignore[no-untyped-def]
    """Difference of two tuples of three."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@njit(no_cpython_wrapper=True)
def _row(simplex, i):  # type: ignore[no-untyped-def]
    return (simplex[i, 0], simplex[i, 1], simplex[i, 2])


@njit(no_cpython_wrapper=True)
def _keep(simplex, i, point):  # type: ignore[no-untyped-def]
    simplex[i, 0], simplex[i, 1], simplex[i, 2] = point


@njit(no_cpython_wrapper=True)
def evolve(simplex, count):  # type: ignore[no-untyped-def]
    """Reduce a simplex to the part that faces the origin.

    Args:
        simplex: (4, 3) corners, the newest at `count - 1`; rewritten in place.
        count: Number of corners.

    Returns:
        The number of corners kept, the direction from them to the origin (of any length), and
        whether the origin is inside (for a tetrahedron only).
    """
    newest = _row(simplex, count - 1)
    if count == 1:
        return 1, (-newest[0], -newest[1], -newest[2]), False
    if count == 2:
        kept, towards = _edge(simplex, newest, _row(simplex, 0))
        return kept, towards, False
    if count == 3:
        kept, towards = _triangle(simplex, newest, _row(simplex, 1), _row(simplex, 0))
        return kept, towards, False
    return _tetrahedron(simplex, newest, _row(simplex, 2), _row(simplex, 1), _row(simplex, 0))


@njit(no_cpython_wrapper=True)
def _edge(simplex, a, b):  # type: ignore[no-untyped-def]
    """Edge from the newest corner a to b; the origin cannot lie beyond b."""
    ab, ao = minus(b, a), (-a[0], -a[1], -a[2])
    if dot(ab, ao) <= 0.0:
        _keep(simplex, 0, a)
        return 1, ao
    _keep(simplex, 0, b)
    _keep(simplex, 1, a)
    return 2, cross(cross(ab, ao), ab)


@njit(no_cpython_wrapper=True)
def _triangle(simplex, a, b, c):  # type: ignore[no-untyped-def]
    """Triangle of the newest corner a, and b and c."""
    ab, ac, ao = minus(b, a), minus(c, a), (-a[0], -a[1], -a[2])
    normal = cross(ab, ac)
    if dot(cross(normal, ac), ao) > 0.0:
        if dot(ac, ao) > 0.0:
            _keep(simplex, 0, c)
            _keep(simplex, 1, a)
            return 2, cross(cross(ac, ao), ac)
        return _edge(simplex, a, b)
    if dot(cross(ab, normal), ao) > 0.0:
        return _edge(simplex, a, b)
    if dot(normal, ao) > 0.0:
        _keep(simplex, 0, c)
        _keep(simplex, 1, b)
        _keep(simplex, 2, a)
        return 3, normal
    # Seen from the other side the triangle runs the other way round.
    _keep(simplex, 0, b)
    _keep(simplex, 1, c)
    _keep(simplex, 2, a)
    return 3, (-normal[0], -normal[1], -normal[2])


@njit(no_cpython_wrapper=True)
def _tetrahedron(simplex, a, b, c, d):  # type: ignore[no-untyped-def]
    """Tetrahedron of the newest corner a over the triangle b c d, which faces a."""
    ao = (-a[0], -a[1], -a[2])
    ab, ac, ad = minus(b, a), minus(c, a), minus(d, a)
    if dot(cross(ab, ac), ao) > 0.0:
        kept, towards = _triangle(simplex, a, b, c)
        return kept, towards, False
    if dot(cross(ac, ad), ao) > 0.0:
        kept, towards = _triangle(simplex, a, c, d)
        return kept, towards, False
    if dot(cross(ad, ab), ao) > 0.0:
        kept, towards = _triangle(simplex, a, d, b)
        return kept, towards, False
    return 4, ao, True
