"""Solvers by name, neural ones included: what the stages and a user's notebook call."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import baselines
from baselines import Solver
from baselines.registry import settings
from pipeline.learning.weights import CARD, WeightsError
from pipeline.provenance import ROOT
from robots import Robot

RESULTS = ROOT / "results"
PROFILES = ("quick", "paper", "smoke")  # where trained weights are looked for, best scale first
MODELS = ("compact", "paper", "best", "tiny")


def load_solver(name: str, robot: Robot, weights: Path | None = None, **overrides: Any) -> Solver:
    """Make a solver for a robot.

    Args:
        name: Any name of `python -m pipeline solvers`.
        robot: The robot to solve for.
        weights: Folder of trained weights for a neural solver; where left out, the weights of
            this checkout's own runs are looked for.
        **overrides: Settings of conf/solver/<name>.yaml to replace.

    Returns:
        The solver; `solver.solve(poses)` answers poses (N, 7).

    Raises:
        SolverError: Unknown name or setting, or a package is missing.
        WeightsError: A neural solver without weights for this robot.
    """
    if is_neural(name):
        overrides["weights"] = str(weights or find_weights(robot.name))
    return baselines.load(name, robot, **overrides)


def is_neural(name: str) -> bool:
    """Say whether a solver needs trained weights.

    Raises:
        UnknownSolverError: There is no solver of that name.
    """
    return "weights" in settings(name)


def find_weights(robot: str) -> Path:
    """Return the folder of the trained weights of a robot, of the default profile first.

    Raises:
        WeightsError: Nothing was trained for this robot yet.
    """
    for profile in PROFILES:
        for model in MODELS:
            folder = RESULTS / profile / "train" / robot / model
            if (folder / CARD).exists():
                return folder
    raise WeightsError(
        f"there are no trained weights for {robot}; train with: python -m pipeline train "
        f"robot={robot}"
    )
