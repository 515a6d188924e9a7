"""What a target leaves open: freedoms of the tip along and about the axes of the target's frame.

With target p*, R* and tip p, R the tip is off by u = R*ᵀ (p - p*) along the axes of the target's
frame, and by the rotation vector r = log(R*ᵀ R) about them. Each component has a width that it may
take for nothing; what counts is the rest, e - clip(e, -w, w), and `found` means that its norms are
within the tolerances of the solver.

About one axis that is free altogether the rotation is split into a swing and a twist about that
axis (Dobrowolski, "Swing-twist decomposition in Clifford algebra", 2015), and r is the vector of
the swing alone: the least turn that brings the tip's axis onto the target's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from baselines.errors import FreedomError
from robots import rotations
from robots.arguments import as_floats

Array = NDArray[np.float64]

AXES = "xyz"
FREE = math.inf


@dataclass(frozen=True)
class Freedom:
    """How far the tip may be from a target and still count as there.

    Attributes:
        along_m: Widths along x, y and z of the target's frame [m]: 0 where the position counts,
            infinite where it is free, in between for a tolerance of its own.
        about_rad: Widths about x, y and z of it [rad]; one or all three may be infinite.
    """

    along_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    about_rad: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        """Refuse widths that are none.

        Raises:
            FreedomError: Not three numbers from 0 each, or two axes that may be turned about.
        """
        for name in ("along_m", "about_rad"):
            widths = as_floats(getattr(self, name), f"{name} of a freedom", FreedomError)
            if widths.shape != (3,) or not (widths >= 0.0).all():
                raise FreedomError(
                    f"expected {name} as three widths from 0, along or about x, y and z, got "
                    f"{getattr(self, name)}"
                )
            object.__setattr__(self, name, tuple(widths.tolist()))
        if sum(math.isinf(width) for width in self.about_rad) == 2:
            raise FreedomError(
                f"expected one free axis in about_rad, or all three, got {self.about_rad}: two "
                "turns together reach every rotation"
            )

    @classmethod
    def position_only(cls) -> Self:
        """Any rotation: a target of three numbers."""
        return cls(about_rad=(FREE, FREE, FREE))

    @classmethod
    def free_about(cls, axis: str) -> Self:
        """Any turn about x, y or z of the tip: what a round tool, or an arm of five joints, needs.

        Raises:
            FreedomError: The axis is none of x, y and z.
        """
        if axis not in AXES or len(axis) != 1:
            raise FreedomError(f"expected the axis x, y or z of the tip, got {axis!r}")
        x, y, z = (FREE if name == axis else 0.0 for name in AXES)
        return cls(about_rad=(x, y, z))

    @property
    def widths(self) -> Array:
        """(6,) along [m], then about [rad]."""
        return np.array([*self.along_m, *self.about_rad])


def widths_of(freedom: Freedom | Sequence[Freedom], count: int) -> Array:
    """Return the widths of `count` poses, (N, 6) in m and rad.

    Args:
        freedom: One for all poses, or one for each.
        count: Number of poses N.

    Raises:
        FreedomError: It is neither.
    """
    each = [freedom] * count if isinstance(freedom, Freedom) else list(freedom)
    if len(each) != count or not all(isinstance(one, Freedom) for one in each):
        raise FreedomError(f"expected a Freedom, or one for each of {count} poses, got {freedom!r}")
    return np.array([one.widths for one in each]).reshape(count, 6)


def nearest_allowed(targets: Array, reached: Array, widths: Array) -> Array:
    """Return of the poses that are as good as a target the one nearest to where the tip is.

    What is left between it and the tip is the error under the freedoms of the target.

    Args:
        targets: (N, 7) poses x y z [m], then unit qw qx qy qz.
        reached: (N, 7) poses of the tip.
        widths: (N, 6) see `Freedom.widths`.

    Returns:
        (N, 7) poses.
    """
    back = rotations.quaternion_conjugate(targets[:, 3:])
    R = rotations.matrix_from_quaternion(targets[:, 3:])
    along, about = widths[:, :3], widths[:, 3:]
    u = np.einsum("nji,nj->ni", R, reached[:, :3] - targets[:, :3])
    position = targets[:, :3] + np.einsum("nij,nj->ni", R, np.clip(u, -along, along))
    swing, twist = swing_twist(rotations.quaternion_multiply(back, reached[:, 3:]), about)
    r = rotations.rotation_vector_from_quaternion(swing)
    kept = rotations.quaternion_from_rotation_vector(np.clip(r, -about, about))
    turned = rotations.quaternion_multiply(
        targets[:, 3:], rotations.quaternion_multiply(kept, twist)
    )
    return np.hstack([position, rotations.canonical(turned)])


def swing_twist(turns: Array, about: Array) -> tuple[Array, Array]:
    """Split rotations into a swing that counts, and what turns about a free axis before it.

    Args:
        turns: (N, 4) unit quaternions, scalar first.
        about: (N, 3) widths about x, y and z [rad].

    Returns:
        Swing and twist, (N, 4) each: turns = swing twist. Without a free axis all is swing, with
        three all is twist.
    """
    free = np.isinf(about)
    twist = np.where(np.hstack([np.ones((len(turns), 1), dtype=bool), free]), turns, 0.0)
    length = np.linalg.norm(twist, axis=1, keepdims=True)
    # Half a turn about an axis across the free one: any twist does.
    none = (length < 1e-12) | ~free.any(axis=1, keepdims=True)
    identity = np.array([1.0, 0.0, 0.0, 0.0])
    twist = np.where(none, identity, twist / np.maximum(length, 1e-12))
    swing = rotations.quaternion_multiply(turns, rotations.quaternion_conjugate(twist))
    return swing, twist
