"""Whether a configuration brings the robot into collision with itself.

All links count: the chain, the hand, and the rest of the body, which stands still at the
robot's posture. Which pairs may touch is data (`allowed_collisions` in `robot.yaml`); pairs that
a joint connects and pairs that never move against each other are left out in any case.
"""

from __future__ import annotations

import threading
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from robots.bodies import Bodies, adjacent_pairs, separable_pairs
from robots.chain import Drive
from robots.collision_kernel import details, verdicts
from robots.contact import TOUCHING, UNSURE
from robots.errors import DescriptionError
from robots.pinocchio_model import expand, reduced_model
from robots.shapes import Shapes, build_shapes
from robots.urdf import Urdf

Array = NDArray[np.float64]
Pair = tuple[str, str]

# Share of random configurations above which a pair counts as always touching; as MoveIt's
# set-up assistant has it. Such a pair says something about the shapes, not about the posture.
ALWAYS = 0.95


class CollisionChecker:
    """Collision queries for one robot: compiled where it is clear, coal where it is close.

    Attributes:
        pairs: Pairs of links that are checked.
        shapes: Their shapes as arrays.
        tree: The driven joints.
    """

    def __init__(
        self, urdf: Urdf, bodies: Bodies, driven: dict[str, Drive], pairs: Iterable[Pair]
    ) -> None:
        self.pairs = list(pairs)
        self._urdf, self._driven, self.tree = urdf, driven, bodies.tree
        named = {link for pair in self.pairs for link in pair}
        self.shapes: Shapes = build_shapes(urdf, bodies, self.pairs, self.mesh_boxes(named))

    @cached_property
    def exact(self) -> ExactChecker:
        """The same pairs in Pinocchio and coal."""
        return ExactChecker(self._urdf, self._driven, self.pairs)

    def mesh_boxes(self, links: Iterable[str]) -> dict[str, Array]:
        """`ExactChecker.boxes` where a link has a mesh; others do without the library."""
        collisions = (shape for link in links for shape in self._urdf.links[link].collisions)
        return self.exact.boxes() if any(shape.kind == "mesh" for shape in collisions) else {}

    def in_collision(self, joints: Array) -> NDArray[np.bool_]:
        """Whether any checked pair touches, (N,) for (N, dof) in rad or m."""
        found = verdicts(self.tree, self.shapes, joints)
        touching = found == TOUCHING
        for row in np.flatnonzero(found == UNSURE):
            states = details(self.tree, self.shapes, joints[row : row + 1])[0]
            touching[row] = any(self.exact.answers(joints[row], np.flatnonzero(states == UNSURE)))
        return touching

    def touching(self, joints: Array) -> NDArray[np.bool_]:
        """Which pairs of links touch, (N, pairs) for (N, dof) in rad or m."""
        states = details(self.tree, self.shapes, joints)
        touching = states == TOUCHING
        for row in np.flatnonzero((states == UNSURE).any(axis=1)):
            unsure = np.flatnonzero(states[row] == UNSURE)
            touching[row, unsure] = list(self.exact.answers(joints[row], unsure))
        if not self.pairs:
            return np.zeros((len(joints), 0), dtype=bool)
        return np.logical_or.reduceat(touching, self.shapes.pair_start[:-1], axis=1)


class ExactChecker:
    """Collision queries by Pinocchio and coal, one configuration at a time.

    Attributes:
        model: Pinocchio's model.
        geometry: Pinocchio's geometry model; its pairs are those of `Shapes.pair_shapes`.
    """

    def __init__(self, urdf: Urdf, driven: dict[str, Drive], pairs: Iterable[Pair]) -> None:
        import pinocchio  # takes a while, and kinematics can do without

        self._library: Any = pinocchio
        self._driven = driven
        self.model: Any
        self.geometry: Any
        self.model, self.geometry = reduced_model(urdf, driven, shapes=True)
        self.geometry.removeAllCollisionPairs()
        for first, second in pairs:
            for a in range(len(urdf.links[first].collisions)):
                for b in range(len(urdf.links[second].collisions)):
                    ids = [
                        self.geometry.getGeometryId(f"{n}_{k}")
                        for n, k in ((first, a), (second, b))
                    ]
                    self.geometry.addCollisionPair(self._library.CollisionPair(*ids))
        self._scratch = threading.local()

    def _data(self) -> tuple[Any, Any]:
        """What Pinocchio writes to; every thread has its own."""
        data: tuple[Any, Any] | None = getattr(self._scratch, "data", None)
        if data is None:
            data = self.model.createData(), self.geometry.createData()
            self._scratch.data = data
        return data

    def in_collision(self, joints: Array) -> NDArray[np.bool_]:
        """Whether any pair touches, (N,) for (N, dof) in rad or m."""
        data, geometry_data = self._data()
        answers = [
            self._library.computeCollisions(
                self.model, data, self.geometry, geometry_data, position, True
            )
            for position in expand(self.model, self._driven, joints)
        ]
        return np.array(answers, dtype=bool)

    def answers(self, q: Array, pairs: Iterable[int]) -> Iterator[bool]:
        """Whether pairs of shapes touch, one after the other.

        Args:
            q: (dof,), rad or m.
            pairs: Rows of `Shapes.pair_shapes`.
        """
        geometry_data = self.placed(q)
        for pair in pairs:
            yield self._library.computeCollision(self.geometry, geometry_data, int(pair))

    def placed(self, q: Array) -> Any:
        """Pinocchio's geometry data with every shape where it is at q (dof,), root's frame."""
        position = expand(self.model, self._driven, q[None])[0]
        data, geometry_data = self._data()
        self._library.updateGeometryPlacements(
            self.model, data, self.geometry, geometry_data, position
        )
        return geometry_data

    def boxes(self) -> dict[str, Array]:
        """Corners (2, 3) of the box around each shape in its own frame, m, by name."""
        found = {}
        for item in self.geometry.geometryObjects:
            item.geometry.computeLocalAABB()
            box = item.geometry.aabb_local
            found[item.name] = np.array([box.min_, box.max_])
        return found


def checked_pairs(
    urdf: Urdf, bodies: Bodies, allowed: Iterable[tuple[str, str, str]]
) -> list[Pair]:
    """Pairs of links to check: those that can move against each other, less the allowed ones.

    Args:
        urdf: The robot.
        bodies: Its links.
        allowed: (link, link, reason).

    Raises:
        DescriptionError: If an allowed pair names a link that does not exist.
    """
    allowed = list(allowed)
    unknown = {link for pair in allowed for link in pair[:2]} - urdf.links.keys()
    if unknown:
        raise DescriptionError(
            f"allowed_collisions names links that {urdf.path} does not have: {sorted(unknown)}"
        )
    skipped = {frozenset(pair[:2]) for pair in allowed}
    return [p for p in separable_pairs(urdf, bodies) if frozenset(p) not in skipped]


def find_allowed_pairs(
    urdf: Urdf, bodies: Bodies, driven: dict[str, Drive], joints: Array
) -> list[tuple[str, str, str]]:
    """Pairs that a joint connects, and pairs that touch in nearly every configuration.

    Args:
        urdf: The robot.
        bodies: Its links.
        driven: What moves each joint.
        joints: (N, dof) random configurations, rad or m; a few hundred are enough.

    Returns:
        (link, link, reason) with the reason `adjacent` or `always`.
    """
    found = [(*sorted(pair), "adjacent") for pair in adjacent_pairs(urdf, bodies)]
    pairs = separable_pairs(urdf, bodies)
    if pairs:
        share = CollisionChecker(urdf, bodies, driven, pairs).touching(joints).mean(axis=0)
        found += [
            (*sorted(pair), "always") for pair, s in zip(pairs, share, strict=True) if s >= ALWAYS
        ]
    return sorted((first, second, reason) for first, second, reason in found)
