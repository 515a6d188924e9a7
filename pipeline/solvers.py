"""What solvers need, neural ones included: kinds of networks, checks before a run, budgets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, cast

import baselines
from baselines import SettingError, SkippedSolver, Solver
from baselines.registry import file_settings, is_outside, solver_class
from pipeline.data.files import read_json
from pipeline.errors import ConfigError
from robots import Robot
from robots.locations import home

if TYPE_CHECKING:
    from pipeline.learning.solver import NeuralSolver
    from pipeline.settings import Config

NETWORKS = {"paper": "Table I", "compact": "compact (ours)", "tiny": "tiny (shows that it runs)"}


def is_neural(name: str) -> bool:
    """Say whether a solver needs weights that this project trains; one outside brings its own.

    Raises:
        UnknownSolverError: There is no solver of that name.
    """
    return "weights" in file_settings(name) and not is_outside(name)


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
            file_settings(name)
            if reason := baselines.skip(name, robot):
                raise SkippedSolver(
                    f"{key}: solver '{name}' cannot run for {robot.name}: {reason}; take another "
                    f"one, see `python -m pipeline solvers`"
                )


def solvers_for(key: str, names: Iterable[str], robot: Robot) -> list[str]:
    """Leave out solvers that know no coupled joints where a robot has them, if others are left.

    So what a configuration lists for all robots serves for such a robot, too.

    Args:
        key: Key of the configuration that lists them.
        names: Names of solvers.
        robot: The robot that they are for.

    Raises:
        UnknownSolverError: There is no solver of a name.
        SkippedSolver: One cannot run for another reason, or none is left.
    """
    names = list(names)
    coupled = len(robot.chain.variable) != robot.dof
    able = [
        name for name in names if not coupled or baselines.skip(name) or solver_class(name).mimics
    ]
    check_solvers({key: able or names}, robot)
    return able


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

    A refined solver takes those of its proposer.

    Raises:
        UnknownSolverError: There is no solver of that name.
        SkippedSolver: It cannot run here.
        SettingError: It, or its proposer, is no neural solver.
    """
    proposer = file_settings(name).get("proposer", name)
    if not is_neural(proposer):
        raise SettingError(f"solver '{proposer}' has no network that could be trained or refined")
    solver = cast("type[NeuralSolver]", solver_class(proposer))
    return solver.kinds, solver.default_model


def check_budgets(config: Config) -> None:
    """Refuse a solver's own budget where that of the evaluation is in its place.

    Raises:
        ConfigError: A run sets such a budget.
    """
    for name in config.evaluate.solvers:
        for key in ("time_s", "iterations"):
            wanted, ours = (
                config.solver.get(name, file_settings(name)).get(key),
                getattr(config.evaluate, key),
            )
            if ours is not None and wanted != file_settings(name).get(key):
                raise ConfigError(
                    f"solver.{name}.{key}={wanted} would do nothing: evaluate.{key}={ours} is in "
                    f"its place; set evaluate.{key}=null as well, or set that"
                )


def sampling_name(solver: str, config: Config) -> str:
    """Return what the samples of a solver are called: with the model where that is not the usual.

    So the generator of the paper's authors, `null_space@null_space_paper`, lies beside ours.
    """
    kinds, usual = models_of(solver)
    own = config.model.kind in kinds and config.model.name != usual
    return f"{solver}@{config.model.name}" if own else solver


def weights_origin(solver: Solver) -> str:
    """Say where the weights of a solver come from; empty for a solver without any."""
    return displayed_path(solver.weights) if solver.weights else ""


def network_of(solver: Solver) -> str:
    """Say which network a solver answers with, and by which recipe; empty for one without."""
    if not solver.weights:
        return ""
    config = read_json(Path(solver.weights) / "card.json")["config"]
    name, train = config["model"]["name"], config["train"]
    clip = train.get("gradient_clip")
    kept = "without clipping" if clip is None else f"clipped at {clip:g}"
    recipe = f"{train['loss']} losses, {train.get('warm_up_steps', 0)} steps of warm-up, {kept}"
    if train.get("precision", "float32") != "float32":
        recipe += f", {train['precision'].replace('_', ' ')}"
    return f"{NETWORKS.get(name, name)} ({recipe})"


def displayed_path(folder: Path) -> str:
    """Return a path as results have it: relative to the checkout where it lies in there."""
    whole = folder.resolve()
    return str(whole.relative_to(home())) if whole.is_relative_to(home()) else str(whole)
