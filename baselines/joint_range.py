"""Limits of joints as compiled code takes them: initial guesses go in, endless joints come back."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from robots.compiled import njit
from robots.limits import FARTHEST, FULL_TURN

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]


class JointRange(NamedTuple):
    """Where initial guesses and answers lie.

    Attributes:
        lower: (dof,) limits [rad or m].
        upper: (dof,) limits [rad or m].
        endless: (dof,) which joints turn for ever.
    """

    lower: Array
    upper: Array
    endless: NDArray[np.bool_]


def joint_range(robot: Robot) -> JointRange:
    """The limits of a robot as compiled code takes them."""
    return JointRange(robot.lower, robot.upper, robot.endless)


@njit()
def take_initial(initial, joints, seeds):  # type: ignore[no-untyped-def]
    """Copy an initial guess, moved into the limits as `checks.check_initial` does.

    Args:
        initial: (1, dof) guess, or (0, dof) for none [rad or m].
        joints: `JointRange`.
        seeds: (K, dof), of which the first row receives it; K > 0.

    Returns:
        Whether that function would take it.
    """
    if initial.shape[0] == 0:
        return True
    for k in range(initial.shape[1]):
        value, lower, upper = initial[0, k], joints.lower[k], joints.upper[k]
        if not abs(value) < np.inf:
            return False
        if joints.endless[k]:
            near = value if abs(value) <= FARTHEST else 0.0
            value = near + FULL_TURN * np.round(((lower + upper) / 2 - near) / FULL_TURN)
        seeds[0, k] = min(max(value, lower), upper)
    return True


@njit(_nrt=False)
def turn_inside(joints, answer):  # type: ignore[no-untyped-def]
    """Turn endless joints as `Robot.nearest_turns` does without a reference: into the limits.

    Args:
        joints: `JointRange`.
        answer: (dof,) joints [rad or m], changed in place.
    """
    for k in range(answer.shape[0]):
        if joints.endless[k]:
            middle = (joints.lower[k] + joints.upper[k]) / 2
            turned = answer[k] + FULL_TURN * np.round((middle - answer[k]) / FULL_TURN)
            answer[k] = min(max(turned, joints.lower[k]), joints.upper[k])


@njit(_nrt=False)
def turn_rows_inside(joints, answers):  # type: ignore[no-untyped-def]
    """The same for answers (N, dof)."""
    for row in range(answers.shape[0]):
        turn_inside(joints, answers[row])


@njit()
def turn_nearest(initial, joints, answer):  # type: ignore[no-untyped-def]
    """Turn endless joints as `Robot.nearest_turns` does, first into the limits.

    Then on to where they are nearest to the initial guess, if there is one.

    Args:
        initial: (1, dof) guess, or (0, dof) for none [rad or m].
        joints: `JointRange`.
        answer: (dof,) joints [rad or m], changed in place.
    """
    turn_inside(joints, answer)
    for k in range(answer.shape[0]):
        if joints.endless[k] and initial.shape[0] == 1 and abs(initial[0, k]) <= FARTHEST:
            answer[k] += FULL_TURN * np.round((initial[0, k] - answer[k]) / FULL_TURN)
