"""Compiled memetic inverse kinematics after the publications of BioIK; not the authors' code.

Starke, Hendrich and Zhang, "Memetic evolution for generic full-body inverse kinematics in robotics
and animation", IEEE Transactions on Evolutionary Computation 2019, and Ruppel et al., "Cost
functions to specify full-body motion and multi-goal manipulation tasks", ICRA 2018.

Species evolve side by side. In one step a species replaces forward kinematics by its first-order
approximation at its best individual, breeds some generations of children from its elites (parents
mixed, their last move carried on, mutations over many orders of magnitude, genes clamped to the
limits), improves the elites by line searches along the gradient (the cost of the approximation is
quadratic, so one line search is exact), and then measures the elites with exact kinematics. A
species that no longer improves is wiped out and born again at random.
"""

from __future__ import annotations

import numpy as np

from baselines.bio_ik_species import (
    ELITES,
    BioOptions,
    born,
    breed,
    line_search,
    new_species,
    select,
)
from baselines.clock import now_ns, pose_key
from baselines.linearise import find_error, find_jacobian, new_linearisation, set_target
from robots.compiled import njit

__all__ = ["FOUND", "OUT_OF_ITERATIONS", "OUT_OF_TIME", "BioOptions", "evolve_rows"]

FOUND, OUT_OF_ITERATIONS, OUT_OF_TIME = 0, 1, 2


@njit(no_cpython_wrapper=True)
def _measure(chain, pose, q, at, weight2):  # type: ignore[no-untyped-def]
    """Exact cost of q (dof,), with its squared distance [m²] and angle [rad²]."""
    distance2, angle2 = find_error(chain, q, pose, at)
    return distance2 + weight2 * angle2, distance2, angle2


@njit(no_cpython_wrapper=True)
def _step(chain, pose, options, key, counter, at, s, k):  # type: ignore[no-untyped-def]
    """Evolve species k by one step; returns the counter, and distance² and angle² of its best."""
    weight = options.rotation_weight
    weight2 = weight * weight
    s.center[:] = s.genes[k, 0]
    _measure(chain, pose, s.center, at, weight2)
    find_jacobian(chain, at)
    for _ in range(options.generations):
        counter = breed(chain, options, key, counter, s, k)
        select(options, at, s, k)
    for e in range(ELITES):
        for _ in range(options.line_searches):
            line_search(chain, options, at, s.genes[k, e], s)
        for i in range(s.center.shape[0]):
            s.momentum[k, e, i] = s.genes[k, e, i] - s.center[i]
    other, _, _ = _measure(chain, pose, s.genes[k, 1], at, weight2)
    cost, distance2, angle2 = _measure(chain, pose, s.genes[k, 0], at, weight2)
    if other < cost:
        for i in range(s.center.shape[0]):
            a, b = s.genes[k, 0, i], s.genes[k, 1, i]
            s.genes[k, 0, i], s.genes[k, 1, i] = b, a
            a, b = s.momentum[k, 0, i], s.momentum[k, 1, i]
            s.momentum[k, 0, i], s.momentum[k, 1, i] = b, a
        cost, distance2, angle2 = _measure(chain, pose, s.genes[k, 0], at, weight2)
    s.cost[k] = cost
    return counter, distance2, angle2


@njit(no_cpython_wrapper=True)
def _evolve(chain, pose, initial, options, at, s, timespec, best):  # type: ignore[no-untyped-def]
    """Solve one pose; writes the best joints and returns (status, steps)."""
    began = now_ns(timespec)
    set_target(pose, at)
    key = pose_key(pose)
    counter = 0
    for k in range(options.species):
        counter = born(chain, key, counter, s, k)
    s.genes[0, 0] = initial
    best[:] = initial
    least, distance2, angle2 = _measure(
        chain, pose, initial, at, options.rotation_weight * options.rotation_weight
    )
    position2, rotation2 = options.position_tolerance_m**2, options.rotation_tolerance_rad**2
    steps = 0
    if distance2 <= position2 and angle2 <= rotation2:
        return FOUND, steps
    while True:
        for k in range(options.species):
            if steps >= options.iterations:
                return OUT_OF_ITERATIONS, steps
            if options.time_ns > 0 and now_ns(timespec) - began >= options.time_ns:
                return OUT_OF_TIME, steps
            counter, distance2, angle2 = _step(chain, pose, options, key, counter, at, s, k)
            steps += 1
            if distance2 <= position2 and angle2 <= rotation2:
                best[:] = s.genes[k, 0]  # another one may cost less, yet be outside a tolerance
                return FOUND, steps
            if s.cost[k] < least:
                least = s.cost[k]
                best[:] = s.genes[k, 0]
            s.age[k] += 1
            if s.age[k] > options.patience:
                if not s.cost[k] < 0.5 * s.reference[k]:
                    counter = born(chain, key, counter, s, k)
                    continue
                s.age[k] = 1
            if s.age[k] == 1:
                s.reference[k] = s.cost[k]


@njit()
def evolve_rows(chain, poses, initial, options, joints, status, steps, time_ns):  # type: ignore[no-untyped-def]
    """Solve a batch on one thread.

    Args:
        chain: The robot's `Chain`.
        poses: (N, 7) targets with unit quaternions.
        initial: (N, dof) where the first species starts, inside the limits.
        options: `BioOptions`.
        joints: (N, dof) receives the best joints.
        status: (N,) receives FOUND, OUT_OF_ITERATIONS or OUT_OF_TIME.
        steps: (N,) receives the steps taken, of all species together.
        time_ns: (N,) receives the time of each pose [ns].
    """
    at = new_linearisation(chain.prismatic.shape[0], joints.shape[1])
    s = new_species(options, joints.shape[1])
    timespec = np.empty(2, dtype=np.int64)
    for row in range(poses.shape[0]):
        began = now_ns(timespec)
        status[row], steps[row] = _evolve(
            chain, poses[row], initial[row], options, at, s, timespec, joints[row]
        )
        time_ns[row] = now_ns(timespec) - began
