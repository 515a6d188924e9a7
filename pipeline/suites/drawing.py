"""Drawing problems until there are enough: proposals in chunks, those in collision dropped."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import PipelineError
from pipeline.suites.problems import Problems, joined

if TYPE_CHECKING:
    from robots import Robot

Propose = Callable[[np.random.Generator], Problems]

CHUNK = 512  # part of what a seed means: another one would give other problems
PATIENCE = 200  # chunks without a single accepted problem after which a suite counts as hopeless


class SuiteError(PipelineError):
    """A suite that cannot be generated, read, or judged for a robot."""


class NoProblemsError(SuiteError):
    """A robot has no such problems, such as poses at limits without limits."""


def draw(robot: Robot, count: int, seed: int, propose: Propose) -> Problems:
    """Draw problems until there are so many whose configurations are free of self-collision.

    Every chunk has a generator of its own, so that a smaller suite is the beginning of a larger.

    Args:
        robot: The robot.
        count: How many.
        seed: Any non-negative integer.
        propose: Gives problems of one chunk, any number of them.

    Raises:
        NoProblemsError: Nothing that is proposed is free of collision.
    """
    kept: list[Problems] = []
    number = accepted = 0
    while accepted < count:
        generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
        problems = propose(generator)
        if len(problems):
            problems = problems.at(_free(robot, problems))
            kept.append(problems)
            accepted += len(problems)
        number += 1
        if number >= PATIENCE and accepted == 0:
            raise NoProblemsError(
                f"none of {PATIENCE} chunks of {CHUNK} proposals for '{robot.name}' gives a "
                "problem that is free of self-collision; look at allowed_collisions in its "
                "robot.yaml, or leave this suite out"
            )
    return joined(kept).at(slice(count))


def uniform_joints(robot: Robot, generator: np.random.Generator) -> NDArray[np.float64]:
    """Return a chunk of uniform configurations within the limits, (CHUNK, dof)."""
    return generator.uniform(robot.lower, robot.upper, (CHUNK, robot.dof))


def _free(robot: Robot, problems: Problems) -> NDArray[np.bool_]:
    """(N,) which configurations, of solution and start, do not collide."""
    free = ~robot.in_collision(problems.joints)
    if problems.start is not None:
        free &= ~robot.in_collision(problems.start)
    return free
