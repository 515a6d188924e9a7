"""Uniform joint samples, filtered, the same for any number of processes.

Samples are drawn in chunks, each with a generator of its own derived from the seed and the
chunk's number, and kept in the order of the chunks. So neither the number of processes nor the
size of the request changes what comes first.
"""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from robots.errors import SamplingError

if TYPE_CHECKING:
    from robots.robot import Robot

Array = NDArray[np.float64]
Progress = Callable[[int], object]

# Part of what a seed means: another chunk size would give other samples.
CHUNK = 2048
# Chunks without a single accepted sample after which the request counts as hopeless.
PATIENCE = 50
# Chunks drawn here before the pace is judged, and the seconds that starting workers costs.
TRIAL = 8
START_UP = 5.0


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


def sample_configurations(
    robot: Robot,
    count: int,
    seed: int = 0,
    collision_free: bool = True,
    workspace_filter: bool = False,
    processes: int = 1,
    progress: Progress | None = None,
) -> Samples:
    """Draw uniform configurations within the limits and keep those that pass the filters.

    Args:
        robot: The robot.
        count: How many to return.
        seed: Any non-negative integer.
        collision_free: Drop configurations in collision.
        workspace_filter: Drop those whose tip is outside `robot.workspace`.
        processes: Worker processes, for work that is long enough to be worth starting them; 1
            stays in this one. The result does not depend on it.
        progress: Called with the number of newly accepted samples now and then.

    Raises:
        SamplingError: If count or seed is negative, or nothing passes the filters.
    """
    if count < 0 or seed < 0:
        raise SamplingError(f"count {count} and seed {seed} must not be negative")
    draw = partial(_chunk, seed=seed, collide=collision_free, box=workspace_filter)
    kept: list[Samples] = []
    accepted = 0
    source, started = _serial(robot, draw), time.perf_counter()
    try:
        while accepted < count:
            kept.append(next(source))
            accepted += len(kept[-1].joints)
            if len(kept) == 1:
                # The first chunk may compile; it says nothing about the pace.
                started = time.perf_counter()
            elif len(kept) == TRIAL and processes > 1:
                pace = (time.perf_counter() - started) / (TRIAL - 1)
                if pace * TRIAL * (count / max(accepted, 1) - 1) > START_UP:
                    source = _pooled(robot, draw, processes, TRIAL)
            if progress is not None:
                progress(len(kept[-1].joints) - max(0, accepted - count))
            if accepted == 0 and len(kept) >= PATIENCE:
                raise SamplingError(
                    f"none of {PATIENCE * CHUNK} uniform configurations of '{robot.name}' passes: "
                    f"{_reasons(kept)}"
                )
    finally:
        source.close()
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


Draw = Callable[["Robot", int], Samples]


def _serial(robot: Robot, draw: Draw) -> Generator[Samples]:
    number = 0
    while True:
        yield draw(robot, number)
        number += 1


def _pooled(robot: Robot, draw: Draw, processes: int, first: int) -> Generator[Samples]:
    # Spawned, not forked: a fork of a process with threads of torch or numba can hang.
    context = multiprocessing.get_context("spawn")
    with context.Pool(processes, _start_worker, (robot, draw)) as pool:
        # Bounded look-ahead, in order: an endless imap would fill the memory.
        ahead = 8 * processes
        waiting = [pool.apply_async(_work, (first + i,)) for i in range(ahead)]
        while True:
            yield waiting.pop(0).get()
            waiting.append(pool.apply_async(_work, (first + ahead,)))
            first += 1


_worker: tuple[Robot, Draw] | None = None


def _start_worker(robot: Robot, draw: Draw) -> None:
    global _worker
    _worker = (robot, draw)


def _work(number: int) -> Samples:
    assert _worker is not None
    robot, draw = _worker
    return draw(robot, number)
