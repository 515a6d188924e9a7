"""Orientations spread evenly over all rotations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from robots.rotations import canonical

PHI = np.sqrt(2.0)
PSI = 1.533751168755204288118041  # the positive root of ψ⁴ = ψ + 4


def spread_orientations(count: int) -> NDArray[np.float64]:
    """Return unit quaternions (count, 4), scalar first, on a super-Fibonacci spiral.

    Alexa, "Super-Fibonacci spirals: fast, low-discrepancy sampling of SO(3)", CVPR 2022,
    algorithm 1.
    """
    s = np.arange(count) + 0.5
    r, R = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    alpha, beta = 2.0 * np.pi * s / PHI, 2.0 * np.pi * s / PSI
    points = [r * np.sin(alpha), r * np.cos(alpha), R * np.sin(beta), R * np.cos(beta)]
    return canonical(np.stack(points, axis=1))
