"""Rows of the paper's protocol: all objects of the set on a line across the action area."""

from __future__ import annotations

import numpy as np

from pipeline.errors import GraspError
from pipeline.grasping.config import PINNED, GraspConfig, ProtocolConfig, SceneConfig
from pipeline.grasping.grip import tip_yaw
from pipeline.grasping.placements import ROW, Setup, pinned
from pipeline.grasping.shapes import extent
from pipeline.grasping.trial import required_scene, rows_of
from pipeline.seeding import derive_seed

ACROSS = np.array([0.0, 1.0, 0.0])  # a row runs along y, from the robot's right to its left


def row_setup(config: GraspConfig, robot: str, number: int, seed: int) -> list[Setup]:
    """Lay out a row by its number alone.

    As in section IV-C of the paper, all objects of the set stand on a line over the width, and
    lines advance over the depth. Their order and the gaps between them are drawn, or all is pinned.

    Args:
        config: The experiment; its scene has the area and the objects.
        robot: Name of the robot, part of the seed.
        number: Number of the row, from 0; it holds the trials from `number` times the objects.
        seed: Root seed.

    Returns:
        What to lay where, from right to left; the numbers are those of the trials.

    Raises:
        GraspError: The objects do not fit on a row.
    """
    scene = required_scene(config, robot)
    if config.placements == PINNED:
        width = len(scene.objects)
        return pinned(robot, ROW, number * width, width)
    line = number % rows_of(scene)
    depth = scene.area.x[0] + line * scene.area.row_step
    order = np.random.default_rng(derive_seed(seed, "grasp", robot, "row", number))
    names = [scene.objects[k] for k in order.permutation(len(scene.objects))]
    draw = np.random.default_rng(derive_seed(seed, "grasp", robot, "gaps", number))
    turns = draw.uniform(-180.0, 180.0, len(names))
    shares = draw.dirichlet(np.ones(len(names) + 1))
    across = _spread(config, scene, names, turns, shares, depth)
    return [
        Setup(
            number=number * len(names) + slot,
            row=line,
            name=name,
            place=(depth, across[slot]),
            yaw=resting_yaw(config, scene, name, turns[slot], (depth, across[slot])),
            error=np.zeros(2),
        )
        for slot, name in enumerate(names)
    ]


def _spread(
    config: GraspConfig,
    scene: SceneConfig,
    names: list[str],
    turns: np.ndarray,
    shares: np.ndarray,
    depth: float,
) -> list[float]:
    """Centres of the objects along the row [m]; free width is shared out, see `_room`.

    The extent of an object depends on its yaw and, where the hand turns with the place, its yaw on
    the place; so the row is laid twice.
    """
    low, high = scene.area.y
    steps = (np.arange(len(names)) + 0.5) / len(names)
    across = list(scene.area.y[0] + steps * (scene.area.y[1] - scene.area.y[0]))
    for _ in range(2):
        ends = [
            extent(
                config.objects[name], resting_yaw(config, scene, name, turn, (depth, at)), ACROSS
            )
            for name, turn, at in zip(names, turns, across, strict=True)
        ]
        taken = sum(end - begin for begin, end in ends)
        free = high - low - taken - (len(names) - 1) * config.protocol.gap
        if free < 0.0:
            raise GraspError(
                f"{', '.join(names)} do not fit on a row of {high - low:.2f} m with gaps of "
                f"{config.protocol.gap} m: choose fewer objects or a smaller grasp.protocol.gap"
            )
        room = _room(free, shares, config.protocol)
        at = low
        for slot, (begin, end) in enumerate(ends):
            at += room[slot] + (config.protocol.gap if slot else 0.0)
            across[slot] = float(at - begin)
            at += end - begin
    return across


def _room(free: float, shares: np.ndarray, protocol: ProtocolConfig) -> np.ndarray:
    """Free width before the first object, beyond the least gap of neighbours, after the last [m].

    Shares of a flat Dirichlet distribution are Beta(1, n) each, so that 1 - (1 - share)^n is
    uniform: where gaps are bounded it draws them, and the ends share what is left.
    """
    room: np.ndarray = free * shares
    if protocol.widest_gap is not None:
        wide = protocol.widest_gap - protocol.gap
        between = wide * (1.0 - (1.0 - shares[1:-1]) ** (len(shares) - 1))
        between *= min(1.0, free / max(between.sum(), 1e-9))
        ends = shares[[0, -1]] / shares[[0, -1]].sum()
        room[1:-1] = between
        room[[0, -1]] = (free - between.sum()) * ends
    return room


def resting_yaw(
    config: GraspConfig, scene: SceneConfig, name: str, turn: float, place: tuple[float, float]
) -> float:
    """Yaw of an object [rad]: any, or the one that the hand grasps across."""
    fixed = config.objects[name].yaw
    yaw = turn if fixed is None else tip_yaw(scene, place) + scene.grip.closing + fixed
    return float(np.deg2rad(yaw))
