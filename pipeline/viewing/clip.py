"""What is played: joints over time, and where in it the player is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pipeline.planning.config import TimingConfig
from pipeline.planning.motion import Motion
from pipeline.planning.timing import time_scale

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Clip:
    """Joints over time.

    Attributes:
        name: What it is called.
        note: A sentence about it.
        time: From 0, ascending [s], shape (T,).
        joints: Joint positions [rad or m], shape (T, dof).
        path: Places of the tip, base frame [m], shape (S, 3); empty where it stays.
    """

    name: str
    note: str
    time: Array
    joints: Array
    path: Array

    @property
    def duration(self) -> float:
        """From start to end [s]."""
        return float(self.time[-1])

    def at(self, time: float) -> Array:
        """Joints at a time [s], linear between samples, shape (dof,)."""
        k = int(np.clip(np.searchsorted(self.time, time, side="right"), 1, len(self.time) - 1))
        span = self.time[k] - self.time[k - 1]
        share = float(np.clip((time - self.time[k - 1]) / span, 0.0, 1.0))
        between: Array = (1.0 - share) * self.joints[k - 1] + share * self.joints[k]
        return between


def clip_of_path(
    name: str, note: str, joints: Array, velocity_limit: Array, timing: TimingConfig
) -> Clip:
    """A clip of joints (S, dof) that are as far apart as the step, played at the motions' speed.

    Args:
        name: What it is called.
        note: A sentence about it.
        joints: Joint positions [rad or m], at least two.
        velocity_limit: Largest joint speeds [rad/s or m/s], shape (dof,).
        timing: Share of the limits, and the cap where a description has none.

    Returns:
        Each joint keeps to its speed at all times.
    """
    limit = timing.speed * np.minimum(velocity_limit, timing.velocity_cap)
    needed = (np.abs(np.diff(joints, axis=0)) / limit).max(axis=1)
    time = np.concatenate([[0.0], np.cumsum(np.maximum(needed, 1.0 / timing.rate))])
    return Clip(name, note, time, joints, np.empty((0, 3)))


def clip_of_motion(name: str, motion: Motion, velocity_limit: Array, timing: TimingConfig) -> Clip:
    """A clip of a planned motion as it would be driven, scaled in time.

    Args:
        name: What it is called.
        motion: Of at least two waypoints.
        velocity_limit: Largest joint speeds [rad/s or m/s], shape (dof,).
        timing: Share of the limits, the cap where a description has none, and the rate.
    """
    limit = np.minimum(velocity_limit, timing.velocity_cap)
    driven = time_scale(motion.joints, limit, timing.speed, timing.rate)
    note = (
        f"{int(motion.found.sum())} of {len(motion.poses)} waypoints found in "
        f"{1e3 * motion.time_s:.1f} ms, tip off by {motion.tip_error_mm.max():.2f} mm at most, "
        f"largest step {motion.largest_step:.3f}, {motion.flips} flips"
    )
    if motion.route is not None:
        note += ", on another curve than requested"
    return Clip(name, note, driven.time, driven.joints, motion.poses[:, :3])


class Player:
    """Where in a film of some duration we are.

    Attributes:
        duration: Of what is played [s]; 0 where there is nothing.
        time: Where we are in it [s].
        playing: Whether time goes by.
        speed: Seconds of the film a second.
    """

    def __init__(self, changed: Callable[[], object] = lambda: None) -> None:
        """Begin with nothing.

        Args:
            changed: Called when another time is to be shown.
        """
        self.duration, self.time, self.playing, self.speed = 0.0, 0.0, False, 1.0
        self._changed = changed

    def load(self, duration: float) -> None:
        """Play a film of a duration [s], from its start."""
        self.duration, self.time, self.playing = duration, 0.0, True
        self._changed()

    def advance(self, seconds: float) -> None:
        """Let time go by; at the end it starts again."""
        if self.playing and self.duration > 0.0:
            self.time = (self.time + self.speed * seconds) % self.duration
            self._changed()

    def seek(self, share: float) -> None:
        """Go to a share of the duration, 0 to 1, and stop there."""
        self.time, self.playing = share * self.duration, False
        self._changed()

    def stop(self) -> None:
        """Play nothing any more."""
        self.duration, self.time, self.playing = 0.0, 0.0, False
