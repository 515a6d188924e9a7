"""What is done to a pose before a closed-form library sees it, and to what it proposes."""

from __future__ import annotations

import numpy as np

from baselines.joint_range import take_initial
from baselines.linearise import new_linearisation, set_target
from baselines.taken_poses import take_pose
from robots.compiled import njit
from robots.kinematics import tip_frame


@njit()
def prepare_query(pose, initial, guess, target, end, joints, tool):  # type: ignore[no-untyped-def]
    """Check a pose and an initial guess, and make the transform that a library takes.

    Args:
        pose: (7,) target in the base frame, x y z [m], qw qx qy qz.
        initial: (1, dof) guess, or (0, dof) for none [rad or m].
        guess: (1, dof) receives the guess inside the limits; left as it is where there is none.
        target: (4, 4) receives the transform of the tip.
        end: (4, 4) receives the transform of the library's end of the arm.
        joints: `JointRange`.
        tool: (4, 4) transform from the tip to that end.

    Returns:
        Whether all numbers are as they should be; where not, the array API has to say so.
    """
    unit = np.empty(7)
    if not (take_pose(pose, unit) and take_initial(initial, joints, guess)):
        return False
    at = new_linearisation(0, 0)
    set_target(unit, at)
    for i in range(3):
        target[i, 3] = unit[i]
        target[3, i] = 0.0
        for j in range(3):
            target[i, j] = at.goal[i, j]
    target[3, 3] = 1.0
    for i in range(4):
        for j in range(4):
            total = 0.0
            for k in range(4):
                total += target[i, k] * tool[k, j]
            end[i, j] = total
    return True


@njit()
def take_candidate(  # type: ignore[no-untyped-def]
    candidates, target, guess, answer, chain, joints, slack, tolerance
):
    """Take the candidate nearest to a guess that is inside the limits and reaches the target.

    Nearest by the joint that differs most. Libraries now and then return a wrong branch at a
    singularity, so every candidate is taken through forward kinematics.

    Args:
        candidates: (K, dof) joints, moved into the limits in place [rad or m].
        target: (4, 4) transform of the tip.
        guess: (1, dof) initial guess [rad or m].
        answer: (dof,) receives the joints.
        chain: The robot's `Chain`.
        joints: `JointRange`.
        slack: How far outside a limit a joint may be and is moved onto it [rad or m].
        tolerance: Largest difference of an entry of the transform.

    Returns:
        Whether there is one.
    """
    count, dof = candidates.shape
    distances = np.empty(count)
    R, p = np.empty((3, 3)), np.empty(3)
    for row in range(count):
        distance = 0.0
        for k in range(dof):
            value, lower, upper = candidates[row, k], joints.lower[k], joints.upper[k]
            if not (lower - slack <= value <= upper + slack):
                distance = np.inf
                break
            candidates[row, k] = min(max(value, lower), upper)
            distance = max(distance, abs(candidates[row, k] - guess[0, k]))
        distances[row] = distance
    for _ in range(count):
        row = int(np.argmin(distances))
        if distances[row] == np.inf:
            return False
        distances[row] = np.inf
        tip_frame(chain, candidates[row], R, p)
        error = 0.0
        for i in range(3):
            error = max(error, abs(p[i] - target[i, 3]))
            for j in range(3):
                error = max(error, abs(R[i, j] - target[i, j]))
        if error <= tolerance:
            answer[:] = candidates[row]
            return True
    return False
