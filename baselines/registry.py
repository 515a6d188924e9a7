"""The solvers by name: one YAML in conf/solver/ each, naming its class and owning its settings."""

from __future__ import annotations

import difflib
import importlib
from typing import TYPE_CHECKING, Any

import yaml

from baselines.errors import SettingError, SkippedSolver, SolverError, UnknownSolverError
from baselines.protocol import Solver
from robots.locations import conf_dir

if TYPE_CHECKING:
    from robots import Robot

FOLDER = conf_dir() / "solver"


def names() -> tuple[str, ...]:
    """All registered solver names, sorted; some may be skipped on this machine (see `skip`)."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def settings(name: str) -> dict[str, Any]:
    """The settings of a solver as its YAML has them, `_target_` included.

    Raises:
        UnknownSolverError: No solver is called `name`.
        SolverError: Its YAML is broken or does not name a class.
    """
    if name not in names():
        close = difflib.get_close_matches(name, names(), n=1)
        hint = f"; did you mean {close[0]!r}?" if close else "."
        raise UnknownSolverError(f"unknown solver {name!r}{hint} Solvers are: {', '.join(names())}")
    path = FOLDER / f"{name}.yaml"
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SolverError(f"{path} is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(values, dict) or not isinstance(values.get("_target_"), str):
        raise SolverError(f"{path}: expected a mapping with `_target_: module.Class`")
    return values


def solver_class(name: str) -> type[Solver]:
    """Import the class of a solver.

    Raises:
        UnknownSolverError: No solver is called `name`.
        SolverError: The class cannot be imported or is no `Solver`.
        SkippedSolver: Its module needs a package that is not installed.
    """
    target = settings(name)["_target_"]
    module_name, _, class_name = target.rpartition(".")
    try:
        found = getattr(importlib.import_module(module_name), class_name)
    except ModuleNotFoundError as error:
        if error.name and not module_name.startswith(error.name):
            raise SkippedSolver(f"solver {name!r}: not installed: {error.name}") from error
        raise SolverError(f"solver {name!r}: cannot import {target}: {error}") from error
    except (ImportError, AttributeError) as error:
        raise SolverError(f"solver {name!r}: cannot import {target}: {error}") from error
    if not (isinstance(found, type) and issubclass(found, Solver)):
        raise SolverError(f"solver {name!r}: {target} is not a subclass of baselines.Solver")
    return found


def skip(name: str, robot: Robot | None = None) -> str | None:
    """Say why a solver cannot run here (for `robot`, if given), or None if it can.

    Raises:
        UnknownSolverError: No solver is called `name`.
    """
    try:
        return solver_class(name).skip(robot)
    except SkippedSolver as reason:
        return str(reason)


def load(name: str, robot: Robot, **overrides: Any) -> Solver:
    """Make a solver for a robot.

    Args:
        name: One of `names()`.
        robot: The robot to solve for.
        **overrides: Settings of its YAML to replace.

    Returns:
        The solver; its `settings` are what it was made with.

    Raises:
        UnknownSolverError: No solver is called `name`.
        SettingError: An override that its YAML does not have, or of another type.
        SkippedSolver: It cannot run here.
    """
    values = settings(name)
    del values["_target_"]
    for key, value in overrides.items():
        _check_override(name, key, value, values)
    reason = skip(name, robot)
    if reason is not None:
        raise SkippedSolver(f"solver {name!r} is skipped for {robot.name}: {reason}")
    effective = {**values, **overrides}
    solver = solver_class(name)(robot, **effective)
    solver.name, solver.settings = name, effective
    return solver


def _check_override(name: str, key: str, value: object, values: dict[str, Any]) -> None:
    if key not in values:
        close = difflib.get_close_matches(key, values, n=1)
        hint = f"; did you mean {close[0]!r}?" if close else ""
        raise SettingError(
            f"solver {name!r} has no setting {key!r}{hint} (settings: {', '.join(values)})"
        )
    expected = values[key]
    if expected is None or value is None:
        return
    if isinstance(expected, float) and isinstance(value, int) and not isinstance(value, bool):
        return
    if type(value) is not type(expected):
        raise SettingError(
            f"solver {name!r}: setting {key!r} is a {type(expected).__name__} "
            f"(such as {expected!r}), got {value!r}"
        )
