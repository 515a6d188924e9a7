"""One query of CycleIK, as it answers and refined, see `baselines.compiled_query`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from baselines.clock import now_ns
from baselines.compiled_query import REFUSED
from baselines.joint_range import take_initial, turn_nearest
from baselines.lm_kernel import FOUND, first_start_only
from baselines.lm_query import refine_query
from baselines.taken_poses import take_pose
from pipeline.learning.cycleik.compiled.answers import answer as write_answers
from pipeline.learning.cycleik.compiled.answers import in_domain, make_work
from robots.compiled import njit
from robots.pose_bound import proves_no
from robots.rows import copy_row

# Statuses of a query whose best hypothesis is outside the tolerances, and of one for a pose that a
# bound proves to have no configuration, however near the hypothesis comes.
NOT_PRECISE, NOT_THERE = 1, 2
PROOF_M, PROOF_RAD = 1e-4, 1e-4  # a pose that is no further beyond a bound may be reached
MM, DEG = 1e3, 180 / np.pi


class NetworkOptions(NamedTuple):
    """What a query of the network alone heeds.

    Attributes:
        position_mm: Largest position error that is found.
        rotation_deg: Largest rotation error.
        time_ns: No limit of time: it is one pass.
    """

    position_mm: float
    rotation_deg: float
    time_ns: int = 0


@njit()
def network_query(  # type: ignore[no-untyped-def]
    pose, initial, answer, options, timed, joints, chain, experts, bound
):
    """Answer one pose with the best hypothesis; an initial guess turns endless joints, no more.

    Args:
        pose: (7,) target in the base frame, x y z [m], qw qx qy qz.
        initial: (1, dof) guess, or (0, dof) for none [rad or m].
        answer: (dof,) receives the joints [rad or m].
        options: `NetworkOptions`.
        timed: None.
        joints: `JointRange`.
        chain: The robot's `Chain`.
        experts: `CompiledExperts`.
        bound: `PoseBound`.

    Returns:
        Status, iterations, starts and time [ns], or (`REFUSED`, 0, 0, 0).
    """
    dof = answer.shape[0]
    targets, hypotheses = np.empty((1, 7)), np.empty((1, 1, dof))
    if not (take_pose(pose, targets[0]) and take_initial(initial, joints, hypotheses[0])):
        return REFUSED, 0, 0, 0
    timespec = np.empty(2, dtype=np.int64)
    began = now_ns(timespec)
    weights, errors = np.empty(2), np.empty((1, 1, 2))
    weights[0], weights[1] = 1 / options.position_mm * MM, 1 / options.rotation_deg * DEG
    work = make_work(experts, 1)
    write_answers(chain, experts, targets, weights, 0, hypotheses, errors, work)
    copy_row(hypotheses[0, 0], answer)
    good = errors[0, 0, 0] * MM <= options.position_mm
    good = good and errors[0, 0, 1] * DEG <= options.rotation_deg
    turn_nearest(initial, joints, answer)
    status = 0 if good else NOT_PRECISE
    if proves_no(bound, targets[0], PROOF_M, PROOF_RAD):
        status = NOT_THERE
    return status, 1, 1, now_ns(timespec) - began


@njit()
def refined_query(  # type: ignore[no-untyped-def]
    pose,
    initial,
    answer,
    options,
    timed,
    joints,
    home,
    tried,
    weights,
    chain,
    experts,
    library,
    bound,
):
    """Solve one pose from an initial guess, if there is one, and then from the best hypotheses.

    Outside the network's box there are none, and it starts as `lm` does.

    Args:
        pose: (7,) target in the base frame, x y z [m], qw qx qy qz.
        initial: (1, dof) guess, or (0, dof) for none [rad or m].
        answer: (dof,) receives the joints [rad or m].
        options: `LmOptions`.
        timed: See `baselines.lm_query.refine_query`.
        joints: `JointRange`.
        home: (dof,) guess where there is neither a first one nor a hypothesis [rad or m].
        tried: How many of them are descended from.
        weights: (2,) of an error in m and in rad when hypotheses are compared.
        chain: The robot's `Chain`.
        experts: `CompiledExperts`.
        library: `SeedLibrary`.
        bound: `PoseBound`.

    Returns:
        Status, iterations, starts and time [ns], or (`REFUSED`, 0, 0, 0).
    """
    dof, given = answer.shape[0], initial.shape[0]
    targets = np.empty((1, 7))
    seeds = np.empty((given + max(tried, 1), dof))
    if not (take_pose(pose, targets[0]) and take_initial(initial, joints, seeds)):
        return REFUSED, 0, 0, 0
    timespec = np.empty(2, dtype=np.int64)
    once, used, began = first_start_only(options), given, np.int64(0)
    # A guess that leads to a solution spares the network; of what it cost nothing is kept. One loop
    # for both descents: two calls would be compiled as two.
    asked = given == 0
    while True:
        if asked:
            began = now_ns(timespec)
            if in_domain(experts, targets[0]):
                used = given + tried
                hypotheses, errors = np.empty((1, tried, dof)), np.empty((1, tried, 2))
                work = make_work(experts, 1)
                write_answers(chain, experts, targets, weights, 0, hypotheses, errors, work)
                for k in range(tried):
                    copy_row(hypotheses[0, k], seeds[given + k])
            elif given == 0:
                used = 1
                copy_row(home, seeds[0])
        chosen = options if asked else once
        status, iterations, starts, spent = refine_query(
            chain, targets[0], seeds[:used], library, chosen, answer, timed, bound
        )
        if asked or status == FOUND:
            break
        asked = True
    turn_nearest(initial, joints, answer)
    return status, iterations, starts, now_ns(timespec) - began if asked else spent
