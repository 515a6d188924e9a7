"""Compiled test of steps between waypoints for branch flips."""

from __future__ import annotations

import numpy as np

from baselines.linearise import find_error, set_target
from pipeline.planning.tracking_kernel import new_tracker
from robots.compiled import njit

# What counts as a branch flip is part of the metric's definition, so it is fixed here. The joints
# step further than a smooth motion of 50 waypoints would, and on the straight way between the two
# configurations the tip strays from the path, by more than half of what the tip itself moves in
# that step. A wide but honest step of the wrist, beside a singularity, is none.
FLIP_STEP = 0.5  # rad or m, largest joint
FLIP_DEVIATION = 0.02  # m, tip from the middle of the two waypoints
FLIP_TURN = 0.2  # rad, rotation of the tip from the middle of the two waypoints


@njit(no_cpython_wrapper=True)
def is_flip(chain, before, after, first, second, t):  # type: ignore[no-untyped-def]
    """Whether a step between two configurations (dof,) at two poses (7,) is a branch flip."""
    wide = 0.0
    for k in range(before.shape[0]):
        wide = max(wide, abs(after[k] - before[k]))
    if wide <= FLIP_STEP:
        return False
    travel2, cosine = 0.0, 0.0
    for i in range(3):
        t.middle[i] = 0.5 * (first[i] + second[i])
        travel2 += (second[i] - first[i]) ** 2
    for i in range(3, 7):
        cosine += first[i] * second[i]
    length = 0.0
    for i in range(3, 7):
        t.middle[i] = first[i] + second[i] if cosine >= 0.0 else first[i] - second[i]
        length += t.middle[i] ** 2
    t.middle[3:] /= np.sqrt(length)
    turn = 2.0 * np.arccos(min(1.0, abs(cosine)))
    t.step[:] = 0.5 * (before + after)
    set_target(t.middle, t.at)
    distance2, angle2 = find_error(chain, t.step, t.middle, t.at)
    astray = distance2 > max(FLIP_DEVIATION**2, 0.25 * travel2)
    return astray or angle2 > max(FLIP_TURN, 0.5 * turn) ** 2


@njit()
def find_flips(chain, joints, poses, flips):  # type: ignore[no-untyped-def]
    """Mark the steps (S - 1,) of a path of joints (S, dof) along poses (S, 7) that are flips."""
    t = new_tracker(chain)
    for i in range(flips.shape[0]):
        flips[i] = is_flip(chain, joints[i], joints[i + 1], poses[i], poses[i + 1], t)
