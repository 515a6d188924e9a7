"""Uniform joint samples, filtered, the same wherever they are drawn.

Samples are drawn in chunks, each with a generator of its own derived from the seed and the
chunk's number, and kept in the order of the chunks. So neither the size of the request changes
what comes first, nor does it matter which process or machine draws a chunk.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robots.arguments import as_int
from robots.errors import SamplingError

if TYPE_CHECKING:
    from robots.robot import Robot

Array = NDArray[np.float64]
Progress = Callable[[int], object]

# Part of what a seed means: another chunk size would give other samples.
CHUNK = 2048
# Chunks without a single accepted sample after which the request counts as hopeless.
PATIENCE = 50
# Chunks drawn here before the pace is judged.
TRIAL = 8
# Chunks handed out beyond those that the acceptance so far asks for: another round costs more.
MARGIN = 1.02


@dataclass(frozen=True)
class Samples:
    """Accepted configurations and how many were refused on the way.

    Attributes:
        joints: (N, dof), rad or m.
        drawn: Uniform samples looked at.
        outside: Of those, the ones whose tip is outside the workspace box.
        colliding: Of the rest, the ones in collision.
    """

    joints: Array
    drawn: int
    outside: int
    colliding: int

    @property
    def acceptance(self) -> float:
        """Share of the samples drawn that passed every filter."""
        return 1.0 - (self.outside + self.colliding) / max(self.drawn, 1)


Draw = Callable[[int], Samples]


@dataclass(frozen=True)
class ChunkExecutor:
    """Other processes or machines that draw chunks.

    Attributes:
        draw: Draws the chunks of these numbers, in their order; its first argument can be pickled.
        start_up_s: Seconds of work here below which it is not worth asking them.
    """

    draw: Callable[[Draw, Sequence[int]], Iterable[Samples]]
    start_up_s: float


def sample_configurations(
    robot: Robot,
    count: int,
    seed: int = 0,
    collision_free: bool = True,
    workspace_filter: bool = False,
    executor: ChunkExecutor | None = None,
    progress: Progress | None = None,
) -> Samples:
    """Draw uniform configurations within the limits and keep those that pass the filters.

    Args:
        robot: The robot.
        count: How many to return.
        seed: Any non-negative integer.
        collision_free: Drop configurations in collision.
        workspace_filter: Drop those whose tip is outside `robot.workspace`.
        executor: Who else draws, where the work is long enough to be worth it; None draws in this
            process. The result does not depend on it.
        progress: Called with the number of newly accepted samples now and then.

    Raises:
        SamplingError: If count or seed is negative, or nothing passes the filters.
    """
    count = as_int(count, "the number of samples", SamplingError)
    seed = as_int(seed, "the seed of the samples", SamplingError)
    if count < 0 or seed < 0:
        raise SamplingError(f"count {count} and seed {seed} must not be negative")
    draw = partial(_chunk, robot, seed=seed, collide=collision_free, box=workspace_filter)
    kept: list[Samples] = []
    accepted = 0
    for samples in _chunks(draw, count, executor):
        if accepted >= count:
            break
        kept.append(samples)
        accepted += len(samples.joints)
        if progress is not None:
            progress(len(samples.joints) - max(0, accepted - count))
        if accepted == 0 and len(kept) >= PATIENCE:
            raise SamplingError(
                f"none of {PATIENCE * CHUNK} uniform configurations of '{robot.name}' passes: "
                f"{_reasons(kept)}"
            )
    joints = np.concatenate([np.empty((0, robot.dof)), *(s.joints for s in kept)])[:count]
    drawn, outside, colliding = (
        sum(getattr(s, key) for s in kept) for key in ("drawn", "outside", "colliding")
    )
    return Samples(np.ascontiguousarray(joints), drawn, outside, colliding)


def _reasons(kept: list[Samples]) -> str:
    outside, colliding = sum(s.outside for s in kept), sum(s.colliding for s in kept)
    return (
        f"{outside} have the tip outside the workspace box, {colliding} more collide; look at "
        f"workspace and allowed_collisions in its robot.yaml"
    )


def _chunk(robot: Robot, number: int, seed: int, collide: bool, box: bool) -> Samples:
    """Draw and filter chunk `number`."""
    generator = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(number,)))
    joints = generator.uniform(robot.lower, robot.upper, (CHUNK, robot.dof))
    drawn = inside = len(joints)
    if box:
        position = robot.forward_kinematics(joints)[:, :3]
        low, high = robot.workspace
        joints = joints[((position >= low) & (position <= high)).all(axis=1)]
        inside = len(joints)
    if collide:
        joints = joints[~robot.in_collision(joints)]
    return Samples(joints, drawn, drawn - inside, inside - len(joints))


def _chunks(draw: Draw, count: int, executor: ChunkExecutor | None) -> Iterator[Samples]:
    """Yield the chunks in order, without end; some here, the rest from whoever else draws."""
    if executor is None:
        yield from map(draw, itertools.count())
        return
    accepted, began = 0, time.perf_counter()
    for number in range(TRIAL):
        samples = draw(number)
        accepted += len(samples.joints)
        if number == 0:
            began = time.perf_counter()  # the first chunk may compile: it says nothing of the pace
        yield samples
    pace, drawn = (time.perf_counter() - began) / (TRIAL - 1), TRIAL
    while True:
        share = accepted / drawn  # of a chunk that is accepted, in samples
        missing = math.ceil(MARGIN * (count - accepted) / share) if share else TRIAL
        numbers = range(drawn, drawn + max(missing, 1))
        here = pace * len(numbers) < executor.start_up_s
        for samples in map(draw, numbers) if here else executor.draw(draw, numbers):
            drawn, accepted = drawn + 1, accepted + len(samples.joints)
            yield samples
