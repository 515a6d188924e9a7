"""Compiled continuation: from a solution of one waypoint to one of the next, on the same branch.

A step predicts and corrects (Allgower and Georg, "Introduction to Numerical Continuation Methods",
chapter 2). The predictor is one damped step from the joints at the waypoint before, with a motion
in the null space added for redundant arms (Siciliano et al., "Robotics: Modelling, Planning and
Control", section 3.5.1); the corrector is Levenberg-Marquardt with joint limits as an active set,
as in `baselines.lm_kernel`, but without restarts: what does not converge is lost.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.damped_step import damped_step
from baselines.linearise import Linearisation, find_error, new_linearisation, set_target
from robots.compiled import njit

Array = NDArray[np.float64]

CORRECTIONS = 12  # steps after which a waypoint that was not reached is lost


class Tracker(NamedTuple):
    """Arrays that one thread works in.

    Attributes:
        at: Kinematics of the configuration at hand.
        solved: (6,) solution of a damped system.
        residual: (6,) its right-hand side.
        step: (dof,) joint step [rad or m].
        free: (dof,) joints that are not frozen at a limit.
        q: (dof,) the configuration at hand [rad or m].
        bias: (dof,) motion in the null space to add to a step [rad or m].
        middle: (7,) pose half way between two waypoints.
    """

    at: Linearisation
    solved: Array
    residual: Array
    step: Array
    free: NDArray[np.bool_]
    q: Array
    bias: Array
    middle: Array


@njit()
def new_tracker(chain):  # type: ignore[no-untyped-def]
    """Room for the chain of a robot."""
    dof = chain.lower.shape[0]
    return Tracker(
        new_linearisation(chain.prismatic.shape[0], dof),
        np.empty(6),
        np.empty(6),
        np.empty(dof),
        np.empty(dof, dtype=np.bool_),
        np.empty(dof),
        np.zeros(dof),
        np.empty(7),
    )


@njit()
def reach_pose(chain, pose, options, biased, t):  # type: ignore[no-untyped-def]
    """Descend from t.q to a pose (7,) and say whether it was reached; t.q is where it ended.

    Args:
        chain: The chain of the robot.
        pose: The pose, base frame [m, unit quaternion].
        options: `LmOptions`; tolerances, damping and active-set passes are used.
        biased: Whether the first step adds the null-space motion t.bias.
        t: The `Tracker`.
    """
    position2 = options.position_tolerance_m**2
    rotation2 = options.rotation_tolerance_rad**2
    set_target(pose, t.at)
    for attempt in range(CORRECTIONS + 1):
        distance2, angle2 = find_error(chain, t.q, pose, t.at)
        if distance2 <= position2 and angle2 <= rotation2 and not (biased and attempt == 0):
            return True
        if attempt == CORRECTIONS:
            break
        if attempt == 0 and not biased:
            t.bias[:] = 0.0
        damping = options.damping + options.damping_gain * (distance2 + angle2)
        damped_step(chain, t, t.bias, damping, options.max_active_set_passes)
        t.bias[:] = 0.0
    return False


@njit(no_cpython_wrapper=True)
def avoid_limits(chain, share, t):  # type: ignore[no-untyped-def]
    """Write a null-space motion of every joint away from its limits, by the cube of its position.

    Args:
        chain: The chain of the robot.
        share: Motion of a joint that is at its limit [rad or m].
        t: The `Tracker`; t.bias is written for t.q.
    """
    for k in range(t.q.shape[0]):
        half = 0.5 * (chain.upper[k] - chain.lower[k])
        off = (t.q[k] - chain.lower[k]) / half - 1.0 if half > 0.0 else 0.0
        t.bias[k] = -share * off * off * off
