"""Solvers by name, neural ones included: what the stages and a user's notebook call."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import baselines
from baselines import SkippedSolver, Solver
from baselines.registry import settings, solver_class
from pipeline.errors import ConfigError
from pipeline.learning.weights import CARD, WeightsError, kind_of, shipped_weights
from pipeline.locations import results
from robots import Robot

if TYPE_CHECKING:
    from pipeline.learning.solver import CycleIk

RESULTS = results()
PROFILES = ("quick", "paper", "smoke")  # where trained weights are looked for, best scale first
MODELS = ("compact", "paper")  # before any other architecture, which go by name


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
        overrides["weights"] = str(weights or find_weights(robot.name, *models_of(name)))
    return baselines.load(name, robot, **overrides)


def is_neural(name: str) -> bool:
    """Say whether a solver needs trained weights.

    Raises:
        UnknownSolverError: There is no solver of that name.
    """
    return "weights" in settings(name)


def check_solvers(requested: Mapping[str, Iterable[str]], robot: Robot) -> None:
    """Stop before anything is made if a solver is unknown or cannot run.

    Args:
        requested: Names of solvers by the key of the configuration that lists them.
        robot: The robot that they are for.

    Raises:
        UnknownSolverError: There is no solver of a name.
        SkippedSolver: One cannot run here or for this robot.
    """
    for key, names in requested.items():
        for name in names:
            settings(name)
            if reason := baselines.skip(name, robot):
                raise SkippedSolver(
                    f"{key}: solver '{name}' cannot run for {robot.name}: {reason}; take another "
                    f"one, see `python -m pipeline solvers`"
                )


def check_seeder(key: str, name: str, robot: Robot) -> None:
    """Stop before anything is made if a solver cannot give initial guesses.

    Raises:
        UnknownSolverError: There is no solver of that name.
        SkippedSolver: It cannot run here or for this robot.
        ConfigError: It is a local solver, which needs an initial guess itself.
    """
    check_solvers({key: [name]}, robot)
    if not is_neural(name):
        neural = ", ".join(n for n in baselines.names() if is_neural(n))
        raise ConfigError(
            f"{key}: '{name}' needs an initial guess itself; expected home or one of {neural}"
        )


def models_of(name: str) -> tuple[tuple[str, ...], str]:
    """Return the kinds of networks that a neural solver takes, and the model trained for it.

    Raises:
        UnknownSolverError: There is no solver of that name.
        SkippedSolver: It cannot run here.
    """
    solver = cast("type[CycleIk]", solver_class(name))
    return solver.kinds, solver.default_model


def find_weights(robot: str, kinds: Collection[str], model: str) -> Path:
    """Return the folder of the trained weights of a robot, of the default profile first.

    Where this checkout trained none, the weights that come with the project are taken.

    Args:
        robot: Name of the robot.
        kinds: Kinds of networks whose weights will do.
        model: What to train (conf/model) where there are none.

    Raises:
        WeightsError: Nothing of these kinds was trained for this robot yet.
    """
    for profile in PROFILES:
        cards = (RESULTS / profile / "train" / robot).glob(f"*/{CARD}")
        fitting = (card.parent for card in cards if kind_of(card.parent) in kinds)
        if folders := sorted(fitting, key=_preference):
            return folders[0]
    shipped = shipped_weights(robot)
    if (shipped / CARD).exists() and kind_of(shipped) in kinds:
        return shipped
    raise WeightsError(
        f"there are no trained weights of kind {' or '.join(kinds)} for {robot}; train with: "
        f"python -m pipeline train robot={robot} model={model}"
    )


def _preference(folder: Path) -> tuple[int, str]:
    rank = MODELS.index(folder.name) if folder.name in MODELS else len(MODELS)
    return rank, folder.name
