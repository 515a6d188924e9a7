"""Random restarts that depend on the target alone: not on batch, order, process or thread."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray


def restart_configurations(
    pose: NDArray[np.float64],
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
) -> Iterator[NDArray[np.float64]]:
    """Yield endless uniform configurations inside the limits, the same for the same pose.

    Args:
        pose: (7,) target; its bytes seed the generator (the quaternion's sign does not count).
        lower: (dof,) lower limits [rad or m].
        upper: (dof,) upper limits [rad or m].
    """
    key = hashlib.sha256(np.concatenate([pose[:3], np.abs(pose[3:])]).tobytes()).digest()
    generator = np.random.Generator(np.random.Philox(key=int.from_bytes(key[:16], "little")))
    while True:
        yield generator.uniform(lower, upper)
