"""What came of following a path that is known from its first pose to its last."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class FollowedPath:
    """Joints along a path, without a jump.

    Attributes:
        joints: (S, dof) [rad or m]; NaN from the first pose on that is not reached.
        reached: Poses that are reached, from the first one on.
        attempts: How often the path was begun.
    """

    joints: NDArray[np.float64]
    reached: int
    attempts: int

    @property
    def complete(self) -> bool:
        """Whether all poses are reached."""
        return self.reached == len(self.joints)
