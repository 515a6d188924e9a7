"""The map: a grid of places around what the tip reaches, and orientations asked for at each."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines import Budget, Freedom, Solver
from pipeline.evaluation.cache import ChunkCache
from pipeline.reachability.config import FREEDOMS, ReachConfig
from pipeline.reachability.orientations import spread_orientations
from robots.reach_bound import reach_bound
from robots.rounding import rounded

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

COLUMNS = {
    "x": "middle of the voxel in the base frame [m]; likewise y and z",
    "share": "of the orientations that were asked for, those that were reached",
    "count": "how many that are",
}
SAMPLES, SEED = 20_000, 0  # random configurations whose tips the grid surrounds


def grid(robot: Robot, spacing_m: float) -> Array:
    """Return the middles of all voxels of a box around the reach, (V, 3) in m, x slowest.

    They lie at multiples of the spacing, so that maps of several robots fit each other. The box
    surrounds the tips of random configurations with a voxel to spare.
    """
    joints = robot.sample(SAMPLES, seed=SEED, collision_free=False)
    points = robot.forward_kinematics(joints)[:, :3] / spacing_m
    low, high = np.floor(points.min(axis=0)) - 1, np.ceil(points.max(axis=0)) + 1
    axes = [np.arange(a, b + 1) for a, b in zip(low, high, strict=True)]
    mesh = np.meshgrid(*axes, indexing="ij")
    return rounded(spacing_m * np.stack([values.ravel() for values in mesh], axis=1))


def reach_map(
    robot: Robot,
    solver: Solver,
    places: Array,
    config: ReachConfig,
    cache: ChunkCache,
    progress: Callable[[int], object] = lambda count: None,
) -> pd.DataFrame:
    """Ask a solver for every orientation at every place, batch by batch.

    Places beyond the proven bound of the reach are not asked for: nothing is reached there.

    Args:
        robot: The robot.
        solver: Made for it.
        places: (V, 3) middles of the voxels in the base frame [m], see `grid`.
        config: Orientations, freedom, budget and places of a batch.
        cache: Of finished batches, so that a killed run continues.
        progress: Called with the number of places finished.

    Raises:
        AbilityError: The solver knows whole poses only, and a part of them is free.

    Returns:
        A row a voxel with the columns of `COLUMNS`.
    """
    turns = spread_orientations(config.orientations)
    counts = np.zeros(len(places), dtype=np.int64)
    near = np.flatnonzero(reach_bound(robot).beyond(places) <= 0.0)
    progress(len(places) - len(near))
    for start in range(0, len(near), config.chunk):
        chosen = near[start : start + config.chunk]
        name = f"places_{start:08d}"
        kept = cache.get(name)
        if kept is None:
            found = _reached(solver, places[chosen], turns, config)
            kept = pd.DataFrame({"count": found})
            cache.put(name, kept)
        counts[chosen] = kept["count"].to_numpy(dtype=np.int64)
        progress(len(chosen))
    x, y, z = places.T
    share = counts / config.orientations
    return pd.DataFrame({"x": x, "y": y, "z": z, "share": share, "count": counts})


def _reached(solver: Solver, places: Array, turns: Array, config: ReachConfig) -> NDArray[np.int64]:
    """How many of the orientations (K, 4) are found at each of the places (V, 3)."""
    poses = np.hstack([np.repeat(places, len(turns), axis=0), np.tile(turns, (len(places), 1))])
    heeds = "iterations" in solver.budgets
    budget = Budget(iterations=config.iterations) if heeds else None
    freedom = FREEDOMS[config.freedom]
    if freedom == Freedom():
        found = solver.solve(poses, budget=budget).found
    else:
        found = solver.solve_partial(poses, freedom, budget=budget).found
    return np.asarray(found.reshape(len(places), len(turns)).sum(axis=1), dtype=np.int64)
