"""Errors that a real robot may have: how large each may be, and why so large."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Error:
    """One error, whose size is a share of its range: 0 is none, 1 the largest.

    Attributes:
        key: What `grasp.ablation.vary` calls it.
        title: For people, with the unit of its values.
        perfect: Value of the key at share 0.
        worst: Value at share 1.
        shown: What a value is multiplied with for people.
        source: Where the range comes from.
    """

    key: str
    title: str
    perfect: float
    worst: float
    shown: float
    source: str

    def value(self, share: float) -> float:
        """Return the key's value at a share of the range: scales fall by factors."""
        if self.perfect:
            return float(self.perfect * (self.worst / self.perfect) ** share)
        return share * self.worst

    def said(self, share: float) -> float:
        """Return the value for people."""
        return self.shown * self.value(share)


DEGREE = float(np.deg2rad(1.0))
ERRORS = (
    Error(
        *("position_error", "place [mm]", 0.0, 0.030, 1e3),
        "where the object is believed to be, in a random direction: users of eye-in-hand "
        "calibration report 10 to 30 mm (conf/perception/miscalibrated.yaml)",
    ),
    Error(
        *("zero_offset", "zeros of the joints [deg]", 0.0, 2.0 * DEGREE, 1 / DEGREE),
        "standard deviation: with 2 deg the tip is some 15 to 25 mm off, as arms that nobody has "
        "calibrated are taken to be (14.6 mm and 4.05 deg: Lembono, Suarez-Ruiz and Pham, SCALAR, "
        "IROS 2018)",
    ),
    Error(
        *("backlash", "play of the joints [deg]", 0.0, 1.0 * DEGREE, 1 / DEGREE),
        "0.1 deg (DYNAMIXEL PRO) to 0.33 deg (MX-64, MX-106) when new, by ROBOTIS; three times as "
        "much when worn is an assumption",
    ),
    Error(
        *("tension_scale", "tension of the tendons [share]", 1.0, 0.1, 1.0),
        "share of the scene's tension, which is an assumption itself: a tenth of it, by factors",
    ),
    Error(
        *("friction_scale", "friction of the hand [share]", 1.0, 0.3, 1.0),
        "share of the scene's coefficient, which is an assumption itself: 0.3 of it, that of hard "
        "plastic, by factors",
    ),
    Error(
        *("mass_spread", "spread of the masses [log]", 0.0, 0.5, 1.0),
        "standard deviation of the logarithm; the plush toys' masses are assumptions, and 0.5 is a "
        "factor of 1.65 either way",
    ),
)


def values(shares: Array) -> dict[str, float]:
    """Keys and values of the errors at shares (6,) of their ranges."""
    return {
        error.key: error.value(float(share)) for error, share in zip(ERRORS, shares, strict=True)
    }
