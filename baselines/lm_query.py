"""One query of `lm`, see `baselines.compiled_query`."""

from __future__ import annotations

import numpy as np
from numba import njit

from baselines.compiled_query import REFUSED, take_initial, take_pose, turn_nearest
from baselines.lm_kernel import refine_row


@njit(cache=True)
def lm_query(pose, initial, answer, options, joints, home, chain, library):  # type: ignore[no-untyped-def]
    """Solve one pose from an initial guess, or else from home.

    Args:
        pose: (7,) target in the base frame, x y z [m], qw qx qy qz.
        initial: (1, dof) guess, or (0, dof) for home [rad or m].
        answer: (dof,) receives the joints [rad or m].
        options: `LmOptions`.
        joints: `JointRange`.
        home: (dof,) guess where there is none.
        chain: The robot's `Chain`.
        library: `SeedLibrary`.

    Returns:
        Status, iterations, starts and time [ns], or (`REFUSED`, 0, 0, 0).
    """
    target, seeds = np.empty(7), np.empty((1, home.shape[0]))
    seeds[0] = home
    if not (take_pose(pose, target) and take_initial(initial, joints, seeds)):
        return REFUSED, 0, 0, 0
    outcome = refine_row(chain, target, seeds, library, options, answer)
    turn_nearest(initial, joints, answer)
    return outcome
