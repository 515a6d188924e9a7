"""A proof, in some tens of nanoseconds, that no configuration has a pose.

A target carries every point of the tip's frame to a place. Two of these points are looked at:

- the tip itself, which is never further from the first turning joint than `robots.reach_bound`
  says;
- a point on the axis of the last joint, the wrist's centre where there is one. That joint does not
  move it, so that it is within reach of the joints before, which is shorter. At the edge of reach
  most orientations ask for a wrist that is beyond it.

Every choice of points on the joints' axes gives a bound. The search for a small one goes through
the feet of common perpendiculars and the projections of neighbours, which takes milliseconds where
the search of `robots.reach_bound` takes a second; its bound may be a little larger.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.compiled import njit
from robots.reach_bound import Link, chain_links, half_spans, reach_length

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

ROUNDING_M = 1e-7  # that arithmetic may add to a distance
ROUNDS = 5  # of the search, at most
STEPS_M = [0.1 / 2**k for k in range(10)]  # along an axis, after that
LEAST = 1e-300  # a square by which a number can be divided
# Chains that are longer, or have more sliding joints, go without: the search would take seconds.
MOST_JOINTS, MOST_SLIDING = 24, 4
PARALLEL = 1e-9  # square of the sine below which two axes count as parallel
Z = np.array([0.0, 0.0, 1.0])


class PoseBound(NamedTuple):
    """Points that move with the tip, and how far they are ever from the first turning joint.

    Attributes:
        points: (M, 3) points in the tip's frame [m].
        origins: (M, 3) a point on the axis of the first turning joint, for each, where the sliding
            joints before it are in the middle of their limits; base frame [m].
        radii: (M,) greatest distance between the two [m].
        spans: (k, 3) half a range of each of these sliding joints, at right angles [m].
    """

    points: Array
    origins: Array
    radii: Array
    spans: Array


@njit(_nrt=False)
def proves_no(bound, pose, position_m, rotation_rad):  # type: ignore[no-untyped-def]
    """Whether no configuration can be within tolerances of a pose.

    Args:
        bound: `PoseBound`.
        pose: (7,) target in the base frame, x y z [m], unit qw qx qy qz.
        position_m: Tolerance of the position [m].
        rotation_rad: Tolerance of the rotation [rad]; it moves a point by as much as it is long.
    """
    w, x, y, z = pose[3], pose[4], pose[5], pose[6]
    for m in range(bound.radii.shape[0]):
        px, py, pz = bound.points[m, 0], bound.points[m, 1], bound.points[m, 2]
        # The point turned by the quaternion (w, u): v + 2 w (u x v) + 2 u x (u x v).
        cx, cy, cz = y * pz - z * py, z * px - x * pz, x * py - y * px
        ax = pose[0] - bound.origins[m, 0] + px + 2.0 * (w * cx + y * cz - z * cy)
        ay = pose[1] - bound.origins[m, 1] + py + 2.0 * (w * cy + z * cx - x * cz)
        az = pose[2] - bound.origins[m, 2] + pz + 2.0 * (w * cz + x * cy - y * cx)
        for k in range(bound.spans.shape[0]):
            sx, sy, sz = bound.spans[k, 0], bound.spans[k, 1], bound.spans[k, 2]
            square = max(sx * sx + sy * sy + sz * sz, LEAST)
            share = min(max((ax * sx + ay * sy + az * sz) / square, -1.0), 1.0)
            ax, ay, az = ax - share * sx, ay - share * sy, az - share * sz
        turned = rotation_rad * np.sqrt(px * px + py * py + pz * pz)
        if np.sqrt(ax * ax + ay * ay + az * az) > bound.radii[m] + position_m + turned:
            return True
    return False


@njit(nogil=True, _nrt=False)
def proven_rows(bound, poses, position_m, rotation_rad, proven):  # type: ignore[no-untyped-def]
    """Write into proven (N,) of which poses (N, 7) it is proven that none can be had."""
    for row in range(poses.shape[0]):
        proven[row] = proves_no(bound, poses[row], position_m, rotation_rad)


@lru_cache(maxsize=8)
def pose_bound(robot: Robot) -> PoseBound:
    """Return the bounds of a robot; without points where there are none, so that all may be had."""
    nothing = PoseBound(np.empty((0, 3)), np.empty((0, 3)), np.empty(0), np.empty((0, 3)))
    sliding = robot.chain.prismatic
    if len(sliding) > MOST_JOINTS or sliding.sum() > MOST_SLIDING:
        return nothing
    first, *links = chain_links(robot)
    spans = half_spans(first.corners)
    if not links or not _at_right_angles(spans):
        return nothing
    found = [(np.zeros(3), *_smallest(links, tip=True))]
    last = links[-1]
    if len(links) > 1 and len(last.corners) == 1:  # no joint slides between the axis and the tip
        shifts, radius = _smallest(links[:-1], tip=False)
        found.append((last.rotation.T @ (shifts[-1] * Z - last.corners[0]), shifts, radius))
    middle, axis = first.corners.mean(axis=0), first.rotation[:, 2]
    return PoseBound(
        np.array([point for point, _, _ in found]),
        np.array([middle + shifts[0] * axis for _, shifts, _ in found]),
        np.array([radius + ROUNDING_M for _, _, radius in found]),
        spans,
    )


def _at_right_angles(spans: Array) -> bool:
    products = spans @ spans.T
    return bool(np.allclose(products, np.diag(np.diag(products)), atol=1e-12))


def _smallest(links: list[Link], tip: bool) -> tuple[Array, float]:
    """Shifts along the axes, and of the end along the axis there, with a small bound.

    Args:
        links: From the first revolute joint on.
        tip: Whether the last link ends at the tip, which is where it is, and not at an axis.

    Returns:
        (len(links) + 1,) shifts, the last one that of the end, and the bound [m].
    """
    shifts = np.zeros(len(links) + 1)
    least = reach_length(links, shifts[:-1], shifts[-1])

    def improve(k: int, candidates: list[float]) -> None:
        nonlocal shifts, least
        for candidate in candidates:
            tried = shifts.copy()
            tried[k] = candidate
            length = reach_length(links, tried[:-1], tried[-1])
            if length < least:
                shifts, least = tried, length

    movable = range(len(shifts) - tip)
    for _ in range(ROUNDS):
        before = least
        for k in movable:
            improve(k, _candidates(links, shifts, k))
        if least == before:
            break
    for step in STEPS_M:
        for k in movable:
            improve(k, [shifts[k] - step, shifts[k] + step])
    return shifts, least


def _candidates(links: list[Link], shifts: Array, k: int) -> list[float]:
    """Places on axis k: nearest to the next and the former axis, and to where those sit now."""
    found = []
    if k < len(links):
        link = links[k]
        vector, direction = link.corners.mean(axis=0), link.rotation[:, 2]
        found += [_foot(vector, direction), float((vector + shifts[k + 1] * direction)[2])]
    if k > 0:
        link = links[k - 1]
        vector = -link.rotation.T @ link.corners.mean(axis=0)
        direction = link.rotation.T @ Z
        found += [_foot(vector, direction), float((vector + shifts[k - 1] * direction)[2])]
    return found


def _foot(vector: Array, direction: Array) -> float:
    """Where on the z axis another axis, through a point in a direction (3,), is nearest."""
    cosine = float(direction[2])
    square = 1.0 - cosine * cosine
    if square < PARALLEL:
        return float(vector[2])
    return float((vector[2] - cosine * (vector @ direction)) / square)
