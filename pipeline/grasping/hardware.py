"""What a real arm has and a simulated one lacks: zeros that are off, play, unweighed objects.

All is drawn for a trial from its number and the seed, so that a trial with errors is as repeatable
as one without. With sizes of zero no bit of a trial changes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.grasping.config import HardwareConfig
from pipeline.seeding import derive_seed

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


@dataclass
class Hardware:
    """One robot on one day, with the objects that it finds.

    Play is the operator of that name: a link stands still while its motor crosses the gap, and is
    then drawn along (Nordin and Gutman, Controlling mechanical systems with backlash, Automatica
    38, 2002).

    Attributes:
        offset: Where each joint is when its encoder says zero [rad], shape (dof,).
        backlash: Play of each joint from one end to the other [rad], shape (dof,).
        mass_spread: Standard deviation of the logarithm of objects' masses.
        draw: Of the masses.
        link: Where the links of the joints were sent last [rad or m]; None before the first time.
    """

    offset: Array
    backlash: Array
    mass_spread: float
    draw: np.random.Generator
    link: Array | None = None

    @classmethod
    def perfect(cls, dof: int) -> Hardware:
        """Return what the simulator has by itself."""
        return cls(np.zeros(dof), np.zeros(dof), 0.0, np.random.default_rng(0))

    @classmethod
    def drawn(cls, config: HardwareConfig, robot: Robot, seed: int, number: int) -> Hardware:
        """Draw the hardware of a trial; sliding joints have none of its errors.

        Args:
            config: Sizes of the errors.
            robot: The robot.
            seed: Root seed.
            number: Number of the trial, or of the row of objects.
        """
        draw = np.random.default_rng(derive_seed(seed, "grasp", robot.name, "hardware", number))
        turning = np.ones(robot.dof)
        turning[robot.chain.variable[robot.chain.prismatic]] = 0.0
        offset = config.zero_offset * draw.standard_normal(robot.dof) * turning
        return cls(offset, config.backlash * turning, config.mass_spread, draw)

    def follow(self, joints: Array, velocities: Array | None) -> tuple[Array, Array | None]:
        """Return where the links go, and how fast, when the motors are sent somewhere.

        Args:
            joints: Positions that are commanded [rad or m], shape (dof,).
            velocities: Speeds that are commanded [rad/s or m/s], shape (dof,), or None.
        """
        if not (self.offset.any() or self.backlash.any()):
            return joints, velocities  # at every step of every trial without errors
        sent, half = joints + self.offset, 0.5 * self.backlash
        if self.link is None:
            self.link = sent
        before, self.link = self.link, np.clip(self.link, sent - half, sent + half)
        if velocities is None or not half.any():
            return self.link, velocities
        return self.link, np.where(self.link == before, 0.0, velocities)

    def weigh(self, mass: float) -> float:
        """Return what an object weighs whose mass is stated [kg]."""
        if self.mass_spread == 0.0:
            return mass
        return mass * float(np.exp(self.mass_spread * self.draw.standard_normal()))
