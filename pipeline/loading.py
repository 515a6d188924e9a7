"""Solvers as a user's notebook loads them: by name, with the weights that are there for a robot."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import baselines
from baselines import Solver
from baselines.registry import settings as solver_settings
from pipeline.errors import ConfigError
from pipeline.learning.card import CARD, WeightsError, kind_of, shipped_weights
from pipeline.locations import results
from pipeline.solvers import is_neural, models_of
from robots import Robot


def load_solver(
    name: str,
    robot: Robot,
    weights: str | Path | None = None,
    profile: str | None = None,
    **settings: Any,
) -> Solver:
    """Make a solver for a robot.

    Args:
        name: Any name of `python -m pipeline solvers`.
        robot: The robot to solve for.
        weights: Folder of trained weights for a neural solver, or a file in it; where left out,
            see `find_weights`. Which were taken, `solver.weights` says.
        profile: Whose own trained weights come before those of the project; that of
            conf/config.yaml where left out.
        **settings: Settings of conf/solver/<name>.yaml to replace.

    Returns:
        The solver; `solver.solve(poses)` answers poses (N, 7).

    Raises:
        SolverError: Unknown name or setting, or a package is missing.
        WeightsError: A neural solver without weights for this robot.
        ConfigError: There is no such profile, or weights for a solver that takes none.
    """
    if is_neural(name):
        named = weights or solver_settings(name)["weights"]
        proposer = settings.get("proposer", name)  # of a refined solver: whose weights it needs
        folder = Path(named) if named else find_weights(proposer, robot, profile)
        settings["weights"] = str(folder.parent if folder.is_file() else folder)
    elif weights is not None:
        raise ConfigError(f"solver '{name}' is not neural and takes no weights, got {weights}")
    return baselines.load(name, robot, **settings)


def find_weights(name: str, robot: Robot, profile: str | None = None) -> Path:
    """Return the folder of the trained weights that a neural solver takes for a robot.

    First those that the profile's own runs trained: of its model, or where the solver takes no
    network of that kind, of the model that is meant for the solver. Then those that come with the
    project. Weights of another profile are never taken: those of smoke are toys.

    Args:
        name: Name of the solver.
        robot: The robot.
        profile: Name of a profile; that of conf/config.yaml where left out.

    Raises:
        WeightsError: There are neither.
        ConfigError: There is no such profile.
    """
    from pipeline.config import compose  # Hydra, which only networks are looked up with

    config = compose([] if profile is None else [f"profile={profile}"])
    kinds, meant = models_of(name)
    model = config.model.name if config.model.kind in kinds else meant
    own = results() / config.profile / "train" / robot.name / model
    for folder in (own, shipped_weights(robot.name)):
        if (folder / CARD).exists() and kind_of(folder) in kinds:
            return folder
    raise WeightsError(
        f"there are no trained weights of kind {' or '.join(kinds)} for {robot.name}: none in "
        f"{own}, and none with the project; name a folder with weights=..., or train with: python "
        f"-m pipeline train robot={robot.name} model={model} profile={config.profile}"
    )
