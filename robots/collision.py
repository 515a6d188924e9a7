"""Whether a configuration brings the robot into collision with itself.

All links count: the chain, the hand, and the rest of the body, which stands still at the
robot's posture. Which pairs may touch is data (`allowed_collisions` in `robot.yaml`); pairs that
a joint connects and pairs that never move against each other are left out in any case.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import pinocchio
from numpy.typing import NDArray

from robots.bodies import Bodies, adjacent_pairs, separable_pairs
from robots.chain import Drive
from robots.errors import DescriptionError
from robots.pinocchio_model import expand, reduced_model
from robots.urdf import Urdf

Array = NDArray[np.float64]
Pair = tuple[str, str]

# Share of random configurations above which a pair counts as always touching; as MoveIt's
# set-up assistant has it. Such a pair says something about the shapes, not about the posture.
ALWAYS = 0.95


class CollisionChecker:
    """Collision queries by Pinocchio and coal for one robot.

    Attributes:
        pairs: Pairs of links that are checked.
        model: Pinocchio's model.
        geometry: Pinocchio's geometry model with the pairs of shapes.
    """

    def __init__(self, urdf: Urdf, driven: dict[str, Drive], pairs: Iterable[Pair]) -> None:
        self.pairs = list(pairs)
        self.driven = driven
        self.model: Any
        self.geometry: Any
        self.model, self.geometry = reduced_model(urdf, driven, shapes=True)
        shapes: dict[str, list[int]] = {}
        for index, shape in enumerate(self.geometry.geometryObjects):
            shapes.setdefault(self.model.frames[shape.parentFrame].name, []).append(index)
        self.geometry.removeAllCollisionPairs()
        self.pair_of: list[int] = []
        for number, (first, second) in enumerate(self.pairs):
            for a in shapes[first]:
                for b in shapes[second]:
                    self.geometry.addCollisionPair(pinocchio.CollisionPair(a, b))
                    self.pair_of.append(number)
        self._data = self.model.createData()
        self._geometry_data = self.geometry.createData()

    def in_collision(self, joints: Array) -> NDArray[np.bool_]:
        """Whether any checked pair touches, (N,) for (N, dof) in rad or m."""
        return np.array(
            [
                pinocchio.computeCollisions(
                    self.model, self._data, self.geometry, self._geometry_data, position, True
                )
                for position in expand(self.model, self.driven, joints)
            ],
            dtype=bool,
        )

    def touching(self, joints: Array) -> NDArray[np.bool_]:
        """Which pairs touch, (N, pairs) for (N, dof) in rad or m."""
        touching = np.zeros((len(joints), len(self.pairs)), dtype=bool)
        for row, position in enumerate(expand(self.model, self.driven, joints)):
            pinocchio.computeCollisions(
                self.model, self._data, self.geometry, self._geometry_data, position, False
            )
            for number, result in zip(
                self.pair_of, self._geometry_data.collisionResults, strict=True
            ):
                touching[row, number] |= result.isCollision()
        return touching


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
        share = CollisionChecker(urdf, driven, pairs).touching(joints).mean(axis=0)
        found += [
            (*sorted(pair), "always") for pair, s in zip(pairs, share, strict=True) if s >= ALWAYS
        ]
    return sorted((first, second, reason) for first, second, reason in found)
