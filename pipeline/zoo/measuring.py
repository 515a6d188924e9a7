"""The descent of `lm` on an arm, from home and from a network's best hypothesis."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import numpy as np
from numpy.typing import NDArray

from baselines.lm import LevenbergMarquardt
from baselines.refine import Refined, refine
from pipeline.learning.refined import RefinedSolver
from pipeline.learning.solver import torch_threads
from pipeline.loading import load_solver
from robots import Robot

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Descent:
    """How the descent from one source of seeds went.

    Attributes:
        iterations: Mean of a pose.
        first_start: Share of poses that were solved without a restart.
        found: Share of poses that were solved.
        time_us: Processor time of a pose in a batch of all, with the seeding; median of the rounds.
            On one thread it is the time that a quiet machine takes.
    """

    iterations: float
    first_start: float
    found: float
    time_us: float


def descents(robot: Robot, weights: Path, poses: Array, rounds: int) -> tuple[Descent, Descent]:
    """Measure the descent to poses (N, 7) from home and from the network, in turns, one thread."""
    kernel = load_solver("lm", robot)
    refined = load_solver("cycleik_refined", robot, weights=weights)
    assert isinstance(kernel, LevenbergMarquardt)
    assert isinstance(refined, RefinedSolver)
    options = kernel.options(None)
    home = np.broadcast_to(robot.home, (len(poses), 1, robot.dof))
    sources: list[Callable[[], Array]] = [lambda: home, lambda: refined.proposals(poses, 1)]
    times: list[list[float]] = [[] for _ in sources]
    outcomes: list[Refined] = []
    with torch_threads(1):
        for turn in range(rounds + 1):
            outcomes = []
            for seeds, mine in zip(sources, times, strict=True):
                began = time.process_time()
                outcomes.append(refine(robot, poses, np.ascontiguousarray(seeds()), options))
                if turn:  # the first one compiles and fills caches
                    mine.append(1e6 * (time.process_time() - began) / len(poses))
    home_s, network_s = (
        Descent(
            float(outcome.iterations.mean()),
            float((outcome.found & (outcome.starts == 1)).mean()),
            float(outcome.found.mean()),
            median(mine),
        )
        for outcome, mine in zip(outcomes, times, strict=True)
    )
    return home_s, network_s
