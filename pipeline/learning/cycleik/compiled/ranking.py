"""Hypotheses side by side through forward kinematics, and sorted by error, compiled, float64.

A lane is a hypothesis: number `i` of lane `l` lies at `i * LANES + l` of a flat array, and every
operation is a loop over all lanes, which the compiler turns into vectors. Lanes that nobody needs
are computed too, so that an answer does not depend on what lies beside it.
"""

from __future__ import annotations

import math

import numpy as np

from robots.compiled import njit
from robots.frames import composed, constant_frame, slid, turned
from robots.trigonometry import sine_cosine

LANES = 16  # loops over eight would be unrolled before they can become vectors
FRAME = 12  # numbers of a frame, rotation row by row and then the origin
ERRORS = 3  # numbers that an error has: distance, angle, and what is compared
# arcsin(x) = x + x³ A(x²) on [0, 1/2]: A interpolated at the nodes of Chebyshev, to 3e-13.
_A0, _A1, _A2, _A3, _A4, _A5, _A6, _A7, _A8 = (
    0.16666666666738605, 0.0749999995343847, 0.04464290646832159,
    0.030379945396028313, 0.022412414916311768, 0.01690270735959679,
    0.016863980552061775, 0.0010677750823891597, 0.028346476635715254,
)  # fmt: skip


@njit(error_model="numpy", fastmath={"contract"})
def arc_sine(x):  # type: ignore[no-untyped-def]
    """Angle of a sine in [0, 1], to 3e-13, without a branch or a call.

    From 1/2 on by arcsin(x) = pi / 2 - 2 arcsin(sqrt((1 - x) / 2)).
    """
    upper = x > 0.5
    z = (1.0 - x) * 0.5 if upper else x * x
    root = math.sqrt(z) if upper else x
    low = _A4 + z * (_A5 + z * (_A6 + z * (_A7 + z * _A8)))
    angle = root + root * z * (_A0 + z * (_A1 + z * (_A2 + z * (_A3 + z * low))))
    return math.pi / 2 - 2.0 * angle if upper else angle


@njit(inline="always")
def _frame_of(frames, lane):  # type: ignore[no-untyped-def]
    """Frame tuple of a lane."""
    return (
        frames[lane], frames[LANES + lane], frames[2 * LANES + lane],
        frames[3 * LANES + lane], frames[4 * LANES + lane], frames[5 * LANES + lane],
        frames[6 * LANES + lane], frames[7 * LANES + lane], frames[8 * LANES + lane],
        frames[9 * LANES + lane], frames[10 * LANES + lane], frames[11 * LANES + lane],
    )  # fmt: skip


@njit(inline="always")
def _keep_frame(frames, lane, frame):  # type: ignore[no-untyped-def]
    """Write the frame tuple of a lane."""
    for i in range(FRAME):
        frames[i * LANES + lane] = frame[i]


@njit(_nrt=False, error_model="numpy", fastmath={"contract"})
def tips_of_lanes(chain, joints, begin, frames):  # type: ignore[no-untyped-def]
    """Frames of the tip for a block of lanes.

    Args:
        chain: The `Chain`.
        joints: Flat, holds dof * LANES joint positions [rad or m].
        begin: Where in it the block begins.
        frames: (FRAME * LANES,) receives the frames.
    """
    rotations, translations = chain.rotations, chain.translations
    multipliers, offsets, variables = chain.multiplier, chain.offset, chain.variable
    base = constant_frame(rotations[0], translations[0])
    for lane in range(LANES):
        _keep_frame(frames, lane, base)
    for k in range(variables.shape[0]):
        multiplier, offset = multipliers[k], offsets[k]
        constant = constant_frame(rotations[k + 1], translations[k + 1])
        at = begin + variables[k] * LANES
        position = joints[at : at + LANES]  # indices from 0 on, or each is tested for its sign
        if chain.prismatic[k]:
            for lane in range(LANES):
                frame = slid(_frame_of(frames, lane), multiplier * position[lane] + offset)
                _keep_frame(frames, lane, composed(frame, constant))
        else:
            for lane in range(LANES):
                sine, cosine = sine_cosine(multiplier * position[lane] + offset)
                frame = turned(_frame_of(frames, lane), sine, cosine)
                _keep_frame(frames, lane, composed(frame, constant))


@njit(_nrt=False, error_model="numpy", fastmath={"contract"})
def errors_of_lanes(frames, goals, weights, errors, begin):  # type: ignore[no-untyped-def]
    """Distance [m], angle [rad] and weighted sum of both between frames and goals.

    Args:
        frames: (FRAME * LANES,) tips.
        goals: (FRAME * LANES,) targets.
        weights: (2,) of an error in m and in rad.
        errors: Flat, receives ERRORS * LANES numbers.
        begin: Where in it the block begins.
    """
    of_distance, of_angle = weights[0], weights[1]
    kept = errors[begin : begin + ERRORS * LANES]
    for lane in range(LANES):
        distance2 = chord2 = 0.0
        for i in range(9):
            chord2 += (frames[i * LANES + lane] - goals[i * LANES + lane]) ** 2
        for i in range(9, FRAME):
            distance2 += (frames[i * LANES + lane] - goals[i * LANES + lane]) ** 2
        distance = math.sqrt(distance2)
        # |R - G|² = 8 sin²(angle / 2) for rotations R and G.
        angle = 2.0 * arc_sine(min(math.sqrt(chord2 * 0.125), 1.0))
        kept[lane] = distance
        kept[LANES + lane] = angle
        kept[2 * LANES + lane] = of_distance * distance + of_angle * angle


@njit(inline="always")
def _goal(poses, row):  # type: ignore[no-untyped-def]
    """Frame tuple of the pose in a row of (N, 7)."""
    w, x, y, z = poses[row, 3], poses[row, 4], poses[row, 5], poses[row, 6]
    return (
        1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y),
        poses[row, 0], poses[row, 1], poses[row, 2],
    )  # fmt: skip


@njit(inline="always")
def _place(lane, numbers):  # type: ignore[no-untyped-def]
    """Where the first number of a lane is kept, of so many for each lane of a block."""
    return lane // LANES * (numbers * LANES) + lane % LANES


@njit(_nrt=False)
def measure_outputs(  # type: ignore[no-untyped-def]
    chain, scaling, poses, order, begin, end, heads, outputs, place, width, weights, work
):
    """Unpack hypotheses into lanes, head after head of one row after the other, and measure them.

    Args:
        chain: The robot's `Chain`.
        scaling: (2, dof) middle of the limits and half their distance [rad or m].
        poses: (N, 7) targets.
        order: (2, N), whose second line holds rows of poses.
        begin: Of these, the first that the hypotheses are for.
        end: And the one after the last.
        heads: Hypotheses K of each.
        outputs: Flat, holds the hypotheses in [-1, 1], head after head.
        place: Where they begin in it.
        width: Numbers from row to row in it.
        weights: (2,) of an error in m and in rad when hypotheses are compared.
        work: Has `joints` and `errors`, which receive them, `goals` and `frames`.
    """
    lower, upper, dof = chain.lower, chain.upper, scaling.shape[1]
    joints, goals = work.joints, work.goals
    i = head = 0
    goal = _goal(poses, order[1, begin])
    count = (end - begin) * heads
    for first in range(0, count, LANES):
        for lane in range(min(LANES, count - first)):
            _keep_frame(goals, lane, goal)
            source, target = place + i * width + head * dof, first * dof + lane
            for k in range(dof):
                value = scaling[0, k] + scaling[1, k] * outputs[source + k]
                joints[target + k * LANES] = min(max(value, lower[k]), upper[k])
            head += 1
            if head == heads and i + 1 < end - begin:
                i, head = i + 1, 0
                goal = _goal(poses, order[1, begin + i])
        tips_of_lanes(chain, joints, first * dof, work.frames)
        errors_of_lanes(work.frames, goals, weights, work.errors, first * ERRORS)


@njit(_nrt=False)
def rank_lanes(order, begin, end, heads, work, joints, errors):  # type: ignore[no-untyped-def]
    """Write hypotheses that `measure_outputs` has measured, those of a row best first.

    Args:
        order: (2, N), whose second line holds rows.
        begin: Of these, the first that the hypotheses are for.
        end: And the one after the last.
        heads: Hypotheses of each.
        work: Has `joints` and `errors`.
        joints: (N, K, dof) receives the K best [rad or m]; of equal ones the first comes first.
        errors: (N, K, 2) receives distance [m] and angle [rad].
    """
    wanted, dof = joints.shape[1], joints.shape[2]
    measured, values = work.errors, work.joints
    for i in range(end - begin):
        row = order[1, begin + i]
        for head in range(heads):
            lane, rank = _place(i * heads + head, ERRORS), 0
            mine = measured[lane + 2 * LANES]
            for other in range(heads):
                theirs = measured[_place(i * heads + other, ERRORS) + 2 * LANES]
                # Written so that each rank is taken once, also where an error is not a number.
                if other < head:
                    rank += not mine < theirs
                elif other > head:
                    rank += theirs < mine
            if rank >= wanted:
                continue
            errors[row, rank, 0], errors[row, rank, 1] = measured[lane], measured[lane + LANES]
            lane = _place(i * heads + head, dof)
            for k in range(dof):
                joints[row, rank, k] = values[lane + k * LANES]


@njit()
def merge_ranked(joints, errors, weights):  # type: ignore[no-untyped-def]
    """Put the hypotheses of several experts together, best first; of equal ones the first's first.

    Args:
        joints: (C, N, K, dof) hypotheses of each expert [rad or m].
        errors: (C, N, K, 2) their distance [m] and angle [rad].
        weights: (2,) of an error in m and in rad when hypotheses are compared.

    Returns:
        Hypotheses (N, C K, dof) and their errors (N, C K, 2).
    """
    experts, count, heads, dof = joints.shape
    merged = np.empty((count, experts * heads, dof))
    measured = np.empty((count, experts * heads, 2))
    costs = np.empty(experts * heads)
    for row in range(count):
        for place in range(experts * heads):
            distance, angle = errors[place // heads, row, place % heads]
            costs[place] = weights[0] * distance + weights[1] * angle
        for rank, place in enumerate(np.argsort(costs, kind="mergesort")):
            expert, head = place // heads, place % heads
            merged[row, rank] = joints[expert, row, head]
            measured[row, rank] = errors[expert, row, head]
    return merged, measured
