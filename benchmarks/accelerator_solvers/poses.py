"""Poses to solve: of collision-free samples, and of a Halton sequence."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from robots import Robot, load_robot

Array = NDArray[np.float64]

SEED, CHUNK = 11, 2048


class Poses(NamedTuple):
    """Poses (N, 7), and whether their configurations are known to be free of collision."""

    poses: Array
    free: bool


def prepare(masks: Path, robots: Sequence[str], count: int) -> None:
    """Find which uniform samples are free of collision, for the first `count` that are."""
    bits = {}
    for name in robots:
        robot, parts, found = load_robot(name), [], 0
        while found < count:
            joints = _uniform(robot, len(parts))
            parts.append(~robot.in_collision(joints))
            found += int(parts[-1].sum())
        bits[name] = np.packbits(np.concatenate(parts))
        print(name, found, "of", CHUNK * len(parts), flush=True)
    np.savez_compressed(masks, **bits)


def _uniform(robot: Robot, number: int) -> Array:
    generator = np.random.default_rng(np.random.SeedSequence(SEED, spawn_key=(number,)))
    return generator.uniform(robot.lower, robot.upper, (CHUNK, robot.dof))


def sampled(robot: Robot, count: int, masks: Path | None) -> Poses:
    """Poses of collision-free samples, or of any where no file says which are free."""
    chunks = -(-count // CHUNK)
    if masks is None:
        joints = np.concatenate([_uniform(robot, k) for k in range(chunks)])[:count]
        return Poses(robot.forward_kinematics(joints), False)
    with np.load(masks) as stored:
        free = np.unpackbits(stored[robot.name]).astype(bool)
    joints = np.concatenate([_uniform(robot, k) for k in range(len(free) // CHUNK)])
    joints = joints[free[: len(joints)]]
    if len(joints) < count:
        raise SystemExit(f"{masks} holds {len(joints)} samples of {robot.name}, not {count}")
    return Poses(robot.forward_kinematics(joints[:count]), True)


def halton(robot: Robot, count: int) -> Array:
    """Poses (N, 7) of the configurations of a Halton sequence."""
    shares = qmc.Halton(robot.dof, scramble=False).random(count + 1)[1:]
    return robot.forward_kinematics(robot.lower + shares * (robot.upper - robot.lower))
