"""How far the tip can be from the first turning joint: a bound, by the triangle inequality.

From the first revolute joint on, the tip is the sum of one vector a joint, each turned as a whole
by the joints before it, so that it is never further away than the sum of their lengths. Three
things make the sum smaller and leave it a bound:

- a revolute joint may be thought to sit anywhere on its axis, since a shift along the axis and a
  turn about it commute. Every choice of shifts gives a bound; a search looks for a small one, and
  need not find the smallest;
- a sliding joint stretches its vector by as much as its limits allow. The length of a vector is
  convex in it, so that it is longest at one of the limits;
- two neighbouring vectors are no longer together than at the angle of the joint between them,
  within its limits, at which they are stretched most. Pairs are chosen so that the sum is smallest.

Sliding joints before the first revolute one carry it along: it can be anywhere in a box, whose
corners are known.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robots.limits import FULL_TURN
from robots.rounding import rounded

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

GRAIN_M = 1e-4  # the bound is rounded up to it, so that the search for shifts leaves no trace
ROUNDING_M = 1e-8  # of the origin, and of the targets beyond


@dataclass(frozen=True)
class ReachBound:
    """A bound of the distance between the tip and the first turning joint.

    Attributes:
        origin: (3,) where that joint is when all before it are in the middle of their limits, m.
        spans: (k, 3) how far half a range of each of the k sliding joints before carries it, m.
        radius_m: No tip is further from where the joint is.
    """

    origin: Array
    spans: Array
    radius_m: float

    def farthest(self, directions: Array) -> Array:
        """Return the points of the joint that lie farthest in directions (N, 3), in m."""
        signs = np.where(directions @ self.spans.T >= 0.0, 1.0, -1.0)
        return np.asarray(self.origin + signs @ self.spans)

    def nearest(self, points: Array) -> Array:
        """Return the points of the joint that are nearest to points (N, 3), in m.

        By coordinate descent, exact for one sliding joint and for sliding joints at right angles.
        """
        share = np.zeros((len(points), len(self.spans)))
        for _ in range(50 if len(self.spans) > 1 else 1):
            for k, span in enumerate(self.spans):
                rest = points - self.origin - share @ self.spans + share[:, k, None] * span
                square = max(float(span @ span), 1e-300)
                share[:, k] = np.clip(rest @ span / square, -1.0, 1.0)
        return np.asarray(self.origin + share @ self.spans)

    def beyond(self, points: Array) -> Array:
        """Return how far points (N, 3) are beyond the bound, (N,) in m; below 0 inside."""
        return np.asarray(np.linalg.norm(points - self.nearest(points), axis=1) - self.radius_m)


@dataclass(frozen=True)
class Link:
    """From one revolute axis to the next, or to the tip: a vector that sliding joints stretch.

    Attributes:
        rotation: (3, 3) from the frame after it to the frame before.
        corners: (c, 3) the vector with every sliding joint at one of its limits.
        limits: Lowest and highest angle of the joint at its end, None at the tip.
    """

    rotation: Array
    corners: Array
    limits: tuple[float, float] | None


@lru_cache(maxsize=8)
def reach_bound(robot: Robot) -> ReachBound:
    """Return a proven bound of a robot's reach; see the docstring of this module.

    A robot without a revolute joint has the bound of zero, and its tip in the place of the joint.
    """
    first, *links = chain_links(robot)
    middle = first.corners.mean(axis=0)
    spans = half_spans(first.corners)
    if not links:
        return ReachBound(rounded(middle), rounded(spans), ROUNDING_M)
    shifts = _shifts(links)
    return ReachBound(
        rounded(middle + shifts[0] * first.rotation[:, 2]),
        rounded(spans),
        float(np.ceil((reach_length(links, shifts) + ROUNDING_M) / GRAIN_M) * GRAIN_M),
    )


def _shifts(links: list[Link]) -> Array:
    """Where on its axis each joint is thought to sit, so that the bound is small (any is one)."""
    from scipy import optimize  # whoever solves without asking for a bound need not wait for it

    none = np.zeros(len(links))
    found = optimize.minimize(
        lambda shifts: reach_length(links, shifts),
        none,
        method="Powell",
        options={"xtol": 1e-7, "ftol": 1e-10, "maxiter": 200},
    )
    shifts = np.asarray(found.x, dtype=np.float64)
    shifts[0] = round(float(shifts[0]) / GRAIN_M) * GRAIN_M  # targets are measured from there
    return shifts if reach_length(links, shifts) < reach_length(links, none) else none


def chain_links(robot: Robot) -> list[Link]:
    """Return the chain cut at its revolute joints; the first link ends at the first of them."""
    chain = robot.chain
    links = []
    rotation, parts = np.eye(3), [np.zeros((1, 3))]
    for k, sliding in enumerate(chain.prismatic):
        parts.append((rotation @ chain.translations[k])[None])
        rotation = rotation @ chain.rotations[k]
        ends = _ends(robot, k)
        if sliding:
            parts.append(np.outer(ends, rotation[:, 2]))
            continue
        links.append(Link(rotation, _sums(parts), ends))
        rotation, parts = np.eye(3), [np.zeros((1, 3))]
    parts.append((rotation @ chain.translations[-1])[None])
    return [*links, Link(rotation @ chain.rotations[-1], _sums(parts), None)]


def _ends(robot: Robot, joint: int) -> tuple[float, float]:
    """Lowest and highest position of a driven joint, coupled ones included [rad or m]."""
    chain, variable = robot.chain, int(robot.chain.variable[joint])
    if robot.endless[variable] and not chain.prismatic[joint]:
        return -np.pi, np.pi
    ends = chain.multiplier[joint] * np.array([robot.lower[variable], robot.upper[variable]])
    ends = ends + chain.offset[joint]
    return float(ends.min()), float(ends.max())


def _sums(parts: list[Array]) -> Array:
    """All sums of one row of each part."""
    return np.array([np.sum(rows, axis=0) for rows in itertools.product(*parts)])


def half_spans(corners: Array) -> Array:
    """Return half edges (k, 3) of a box of 2^k corners in the order of `itertools.product`."""
    count = int(np.log2(len(corners)))
    edges = [corners[1 << (count - 1 - k)] - corners[0] for k in range(count)]
    return np.array(edges).reshape(count, 3) / 2.0


def reach_length(links: list[Link], shifts: Array, end: float = 0.0) -> float:
    """Return the bound with each joint so far along its axis: the cheapest way to pair the links.

    Args:
        links: From the first revolute joint on.
        shifts: (len(links),) of the joints at which they begin [m].
        end: How far along the z axis there the point is that the last link leads to [m].
    """
    z = np.array([0.0, 0.0, 1.0])
    ahead = [*shifts[1:], end]
    vectors = [
        link.corners + after * link.rotation[:, 2] - before * z
        for link, before, after in zip(links, shifts, ahead, strict=True)
    ]
    single = [float(np.linalg.norm(vector, axis=1).max()) for vector in vectors]
    best = [0.0, single[0]]
    for k in range(1, len(links)):
        pair = _pair(links[k - 1], vectors[k - 1], vectors[k])
        best.append(min(best[k] + single[k], best[k - 1] + pair))
    return best[-1]


def _pair(link: Link, before: Array, after: Array) -> float:
    """Greatest length of two vectors together over the angle of the joint between them."""
    assert link.limits is not None
    low, high = link.limits
    longest = 0.0
    for a, b in itertools.product(before @ link.rotation, after):
        # |a + Rz(q) b|² = |a|² + |b|² + 2 a_z b_z + 2 |a_xy| |b_xy| cos(q - q0)
        q0 = np.arctan2(a[1], a[0]) - np.arctan2(b[1], b[0])
        turns = np.ceil((low - q0) / FULL_TURN)
        stretched = q0 + turns * FULL_TURN <= high
        cosine = 1.0 if stretched else max(np.cos(low - q0), np.cos(high - q0))
        flat = 2.0 * np.hypot(a[0], a[1]) * np.hypot(b[0], b[1]) * cosine
        square = float(a @ a + b @ b + 2.0 * a[2] * b[2] + flat)
        longest = max(longest, float(np.sqrt(max(square, 0.0))))
    return longest
