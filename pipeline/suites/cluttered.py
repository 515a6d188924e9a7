"""Suite of poses among obstacles, with a configuration that is known to be free of collision.

The configuration is uniform. The first obstacles stand in the way of plain answers: where a link is
in what `lm` finds from home and from random configurations, if the known configuration keeps its
clearance from there. The others come from random directions towards random links of the known
configuration until its clearance stops them, in steps of `GRAIN_M`. A share of that clearance is
requested of a solver, so that it need not find the very configuration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

import baselines
from baselines.registry import using
from pipeline.seeding import derive_seed
from pipeline.suites.config import ClutteredConfig
from pipeline.suites.drawing import draw, uniform_joints
from pipeline.suites.problems import OBSTACLES, Problems, in_turns, reached
from robots import Box, Obstacles, Sphere

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
At = Callable[[Array], Obstacles]  # an obstacle with its centre there

MM_PER_M = 1e3
GRAIN_M = 1e-4  # of the distance at which an obstacle stops
FAR = 20_000  # grains, where it comes from
DECIMALS = 6  # of places and sizes [m]; the last bits of a machine then do not show
PLAIN_DECIMALS = 3  # of plain answers, which a solver gives to its tolerance only
PLAIN = 3  # plain answers of a pose: from home, then from random configurations
TRIES = 10  # places for an obstacle in the way of a plain answer


def cluttered(robot: Robot, config: ClutteredConfig, seed: int) -> Problems:
    """Poses among obstacles, for each clearance in turns; the stratum is the clearance."""
    kinds = len(config.clearances_mm)
    parts = []
    for kind, clearance_mm in enumerate(config.clearances_mm):
        if count := len(range(kind, config.poses, kinds)):
            own = derive_seed(seed, f"{clearance_mm:g}mm")
            parts.append(_surrounded(robot, config, clearance_mm, count, own))
    return in_turns(parts)


def _surrounded(
    robot: Robot, config: ClutteredConfig, clearance_mm: float, count: int, seed: int
) -> Problems:
    name = f"{clearance_mm:g} mm"
    known = draw(robot, count, seed, lambda rng: reached(robot, uniform_joints(robot, rng), name))
    plain = _plain_answers(robot, known, seed)
    said = [
        _obstacles(robot, config, clearance_mm / MM_PER_M, known.joints[row], plain[row], rng)
        for row, rng in enumerate(_generators(seed, count))
    ]
    further = {
        OBSTACLES: np.array([each.to_json() for each in said], dtype=object),
        "clearance_mm": np.full(count, clearance_mm),
    }
    return replace(known, further=further)


def _generators(seed: int, count: int) -> list[np.random.Generator]:
    """One for each pose, so that a smaller suite is the beginning of a larger."""
    own = derive_seed(seed, OBSTACLES)
    return [
        np.random.default_rng(np.random.SeedSequence(own, spawn_key=(row,))) for row in range(count)
    ]


def _plain_answers(robot: Robot, known: Problems, seed: int) -> Array:
    """Configurations (N, PLAIN, dof) that `lm` finds without a word about collisions."""
    with using({}):  # whatever settings a run evaluates lm with
        solver = baselines.load("lm", robot)
    own = derive_seed(seed, "starts")
    starts = [None, *(robot.sample(1, own + k, collision_free=False)[0] for k in range(1, PLAIN))]
    answers = [solver.solve(known.poses, start).joints for start in starts]
    return np.asarray(np.round(np.stack(answers, axis=1), PLAIN_DECIMALS), dtype=np.float64)


def _obstacles(
    robot: Robot,
    config: ClutteredConfig,
    clearance: float,
    known: Array,
    plain: Array,
    rng: np.random.Generator,
) -> Obstacles:
    """Obstacles of one pose.

    Args:
        robot: The robot.
        config: How many, and how large.
        clearance: That the known configuration keeps [m].
        known: (dof,) the known configuration.
        plain: (PLAIN, dof) plain answers.
        rng: Of this pose.
    """
    boxes: list[Box] = []
    spheres: list[Sphere] = []
    around = robot.clearance.centres(known)
    for number in range(config.obstacles):
        placed = None
        if number < config.blocking:
            links = robot.clearance.centres(plain[number % PLAIN])
            placed = _in_the_way(robot, config, clearance, known, links, number, rng)
        if placed is None:
            at = _shape(config, number, rng)
            placed = _stopped(robot, clearance, known, at, around, rng)
        boxes += placed.boxes
        spheres += placed.spheres
    return Obstacles(boxes, spheres, round(config.requested * clearance, DECIMALS))


def _shape(config: ClutteredConfig, number: int, rng: np.random.Generator) -> At:
    """A box or a sphere of a random size."""
    least, most = config.half_size_mm
    x, y, z = (round(half / MM_PER_M, DECIMALS) for half in rng.uniform(least, most, 3).tolist())
    turn = rng.standard_normal(4)
    qw, qx, qy, qz = (round(each, DECIMALS) for each in (turn / np.linalg.norm(turn)).tolist())

    def box(centre: Array) -> Obstacles:
        return Obstacles([Box(_placed(centre), (2 * x, 2 * y, 2 * z), (qw, qx, qy, qz))])

    def sphere(centre: Array) -> Obstacles:
        return Obstacles(spheres=[Sphere(_placed(centre), x)])

    return sphere if number % 2 else box


def _placed(centre: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in np.round(centre, DECIMALS) + 0.0)
    return x, y, z


def _in_the_way(
    robot: Robot,
    config: ClutteredConfig,
    clearance: float,
    known: Array,
    links: Array,
    number: int,
    rng: np.random.Generator,
) -> Obstacles | None:
    """An obstacle around a link of a plain answer; None where the known one would be too near."""
    for _ in range(TRIES):
        at = _shape(config, number, rng)
        placed = at(links[rng.integers(len(links))])
        if _keeps(robot, clearance, known, placed):
            return placed
    return None


def _stopped(
    robot: Robot,
    clearance: float,
    known: Array,
    at: At,
    links: Array,
    rng: np.random.Generator,
) -> Obstacles:
    """An obstacle that has come as near to the known configuration as its clearance lets it."""
    goal, towards = links[rng.integers(len(links))], rng.standard_normal(3)
    towards /= np.linalg.norm(towards)
    near, far = 0, FAR
    while far - near > 1:
        middle = (near + far) // 2
        kept = _keeps(robot, clearance, known, at(goal + middle * GRAIN_M * towards))
        near, far = (near, middle) if kept else (middle, far)
    return at(goal + far * GRAIN_M * towards)


def _keeps(robot: Robot, clearance: float, known: Array, placed: Obstacles) -> bool:
    return bool(robot.clearance.distances(known, placed, 2.0 * clearance)[0] >= clearance)
