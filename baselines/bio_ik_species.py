"""The populations of the memetic solver: how elites are born, bred, selected and improved.

Everything here works on the first-order approximation of the tip pose at one configuration, so that
a child costs a few multiplications; see `baselines.bio_ik_kernel` for the method and its sources.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from baselines.clock import uniform
from robots.compiled import njit

Array = NDArray[np.float64]

ELITES = 2


class BioOptions(NamedTuple):
    """What the kernel needs beside robot, targets and initial guesses.

    Attributes:
        position_tolerance_m: Distance to the target at which a solution is claimed [m].
        rotation_tolerance_rad: Rotation angle at which it is claimed [rad].
        rotation_weight: Metres that one radian counts in the cost [m/rad].
        species: Populations that evolve side by side.
        children: Children per generation.
        generations: Generations per step.
        line_searches: Line searches per elite and step.
        patience: Steps within which a species' cost has to halve; else it is wiped out.
        mutation_octaves: Mutations are spread over these many powers of two below the range.
        iterations: Steps per pose, of all species together.
        time_ns: Time per pose [ns], 0 for no limit.
    """

    position_tolerance_m: float
    rotation_tolerance_rad: float
    rotation_weight: float
    species: int
    children: int
    generations: int
    line_searches: int
    patience: int
    mutation_octaves: int
    iterations: int
    time_ns: int


class Species(NamedTuple):
    """Populations of all species and the arrays that they are bred in."""

    genes: Array  # (species, ELITES, dof)
    momentum: Array  # (species, ELITES, dof), the last move of each elite
    cost: Array  # (species,) exact cost of the first elite
    reference: Array  # (species,) cost at the start of the current patience
    age: NDArray[np.int64]  # (species,) steps since then
    child: Array  # (children + ELITES, dof)
    move: Array  # (children + ELITES, dof)
    fitness: Array  # (children + ELITES,)
    center: Array  # (dof,) where the approximation was made
    residual: Array  # (6,) weighted
    gradient: Array  # (dof,)


@njit(no_cpython_wrapper=True)
def new_species(options, dof):  # type: ignore[no-untyped-def]
    """Room for all species of a robot with `dof` joints; `born` fills it."""
    count, rows = options.species, options.children + ELITES
    return Species(
        np.zeros((count, ELITES, dof)),
        np.zeros((count, ELITES, dof)),
        np.zeros(count),
        np.zeros(count),
        np.zeros(count, dtype=np.int64),
        np.zeros((rows, dof)),
        np.zeros((rows, dof)),
        np.zeros(rows),
        np.zeros(dof),
        np.zeros(6),
        np.zeros(dof),
    )


@njit(no_cpython_wrapper=True)
def born(chain, key, counter, s, k):  # type: ignore[no-untyped-def]
    """Give species k random elites; returns the counter of the random numbers."""
    for e in range(ELITES):
        for i in range(s.center.shape[0]):
            share = uniform(key, counter)
            counter += 1
            s.genes[k, e, i] = chain.lower[i] + share * (chain.upper[i] - chain.lower[i])
            s.momentum[k, e, i] = 0.0
    s.age[k] = 0
    s.cost[k] = np.inf
    s.reference[k] = np.inf
    return counter


@njit(no_cpython_wrapper=True, fastmath={"contract", "reassoc"})
def _approximate(q, at, s, weight):  # type: ignore[no-untyped-def]
    """Cost of q by the first-order approximation at s.center; residual into s.residual."""
    J, e, center = at.jacobian, at.error, s.center
    r0, r1, r2, r3, r4, r5 = e[0], e[1], e[2], e[3], e[4], e[5]
    for i in range(q.shape[0]):
        d = q[i] - center[i]
        r0, r1, r2 = r0 - d * J[i, 0], r1 - d * J[i, 1], r2 - d * J[i, 2]
        r3, r4, r5 = r3 - d * J[i, 3], r4 - d * J[i, 4], r5 - d * J[i, 5]
    r3, r4, r5 = weight * r3, weight * r4, weight * r5
    s.residual[0], s.residual[1], s.residual[2] = r0, r1, r2
    s.residual[3], s.residual[4], s.residual[5] = r3, r4, r5
    return r0 * r0 + r1 * r1 + r2 * r2 + r3 * r3 + r4 * r4 + r5 * r5


@njit(no_cpython_wrapper=True)
def breed(chain, options, key, counter, s, k):  # type: ignore[no-untyped-def]
    """Fill s.child with the elites of species k and their children, s.move with their moves."""
    dof = s.center.shape[0]
    s.child[:ELITES] = s.genes[k]
    s.move[:ELITES] = s.momentum[k]
    for c in range(ELITES, ELITES + options.children):
        first = c & 1
        mixing, carried = uniform(key, counter), uniform(key, counter + 1)
        octave = uniform(key, counter + 2) * options.mutation_octaves
        size = 2.0 ** (-octave)
        counter += 3
        for i in range(dof):
            own, other = s.genes[k, first, i], s.genes[k, 1 - first, i]
            gene = own + mixing * mixing * (other - own) + carried * s.momentum[k, first, i]
            share = uniform(key, counter)
            counter += 1
            gene += (2.0 * share - 1.0) * size * (chain.upper[i] - chain.lower[i])
            gene = min(max(gene, chain.lower[i]), chain.upper[i])
            s.child[c, i] = gene
            s.move[c, i] = gene - own
    return counter


@njit(no_cpython_wrapper=True)
def select(options, at, s, k):  # type: ignore[no-untyped-def]
    """Make the fittest of s.child the elites of species k."""
    for c in range(ELITES + options.children):
        s.fitness[c] = _approximate(s.child[c], at, s, options.rotation_weight)
    for e in range(ELITES):
        best = 0
        for c in range(1, ELITES + options.children):
            if s.fitness[c] < s.fitness[best]:
                best = c
        s.fitness[best] = np.inf
        s.genes[k, e] = s.child[best]
        s.momentum[k, e] = s.move[best]


@njit(no_cpython_wrapper=True, fastmath={"contract", "reassoc"})
def line_search(chain, options, at, q, s):  # type: ignore[no-untyped-def]
    """Move q (dof,) along the gradient to the minimum of the approximated, quadratic cost."""
    weight, dof, J = options.rotation_weight, q.shape[0], at.jacobian
    _approximate(q, at, s, weight)
    r0, r1, r2 = s.residual[0], s.residual[1], s.residual[2]
    r3, r4, r5 = weight * s.residual[3], weight * s.residual[4], weight * s.residual[5]
    s0 = s1 = s2 = s3 = s4 = s5 = length2 = 0.0
    for i in range(dof):
        g = J[i, 0] * r0 + J[i, 1] * r1 + J[i, 2] * r2 + J[i, 3] * r3 + J[i, 4] * r4 + J[i, 5] * r5
        # The gradient must not point out of the box.
        if (q[i] <= chain.lower[i] and g < 0.0) or (q[i] >= chain.upper[i] and g > 0.0):
            g = 0.0
        s.gradient[i] = g
        length2 += g * g
        s0, s1, s2 = s0 + g * J[i, 0], s1 + g * J[i, 1], s2 + g * J[i, 2]
        s3, s4, s5 = s3 + g * J[i, 3], s4 + g * J[i, 4], s5 + g * J[i, 5]
    curvature = s0 * s0 + s1 * s1 + s2 * s2 + weight * weight * (s3 * s3 + s4 * s4 + s5 * s5)
    if curvature <= 0.0:
        return
    step = length2 / curvature
    for i in range(dof):
        q[i] = min(max(q[i] + step * s.gradient[i], chain.lower[i]), chain.upper[i])
