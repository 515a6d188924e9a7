"""The solvers by name: one YAML in conf/solver/ each, naming its class and owning its settings.

Those outside the checkout have none: see `baselines.outside`.
"""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import cache, lru_cache
from pathlib import Path
from types import MappingProxyType, NoneType, UnionType
from typing import TYPE_CHECKING, Any, Union, get_args, get_origin, get_type_hints

import numpy as np
import yaml

from baselines.errors import SettingError, SkippedSolver, SolverError, UnknownSolverError
from baselines.outside import default_settings, target_of
from baselines.protocol import Solver
from robots.arguments import shown
from robots.locations import conf_dir
from robots.suggestions import unknown_name

if TYPE_CHECKING:
    from robots import Robot

FOLDER = conf_dir() / "solver"
TARGET = "_target_"
Settings = Mapping[str, Mapping[str, Any]]

_OF_RUN: ContextVar[Settings] = ContextVar("settings of the run", default=MappingProxyType({}))


def names() -> tuple[str, ...]:
    """All registered solver names, sorted; some may be skipped on this machine (see `skip`)."""
    return tuple(sorted(path.stem for path in FOLDER.glob("*.yaml")))


def settings(name: str) -> dict[str, Any]:
    """The settings of a solver, ``_target_`` included: its YAML's, or within `using` a run's own.

    Raises:
        UnknownSolverError: No solver is called `name`.
        SolverError: Its YAML is broken or does not name a class.
    """
    return {**file_settings(name), **_OF_RUN.get().get(name, {})}


def file_settings(name: str) -> dict[str, Any]:
    """The settings of a solver as its YAML has them, ``_target_`` included.

    Of a solver outside the checkout those are the defaults of its class.

    Raises:
        UnknownSolverError: No solver is called `name`.
        SolverError: Its YAML is broken or does not name a class.
    """
    if is_outside(name):
        target = str(target_of(name))
        return {TARGET: target, **default_settings(target)}
    if not isinstance(name, str) or name not in names():
        raise UnknownSolverError(unknown_name("solver", str(name), names()))
    path = FOLDER / f"{name}.yaml"
    return dict(_read(path, path.stat().st_mtime_ns))


def is_outside(name: str) -> bool:
    """Say whether a name is that of a solver outside the checkout."""
    return isinstance(name, str) and name not in names() and target_of(name) is not None


@lru_cache(maxsize=128)
def _read(path: Path, changed_ns: int) -> dict[str, Any]:
    """The content of a solver's YAML; a file that was changed is read again."""
    try:
        values = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise SolverError(f"{path} is not YAML: {' '.join(str(error).split())}") from error
    if not isinstance(values, dict) or not isinstance(values.get(TARGET), str):
        raise SolverError(f"{path}: expected a mapping with `{TARGET}: module.Class`")
    return values


@contextmanager
def using(of_run: Settings) -> Iterator[None]:
    """Let every solver that is made inside have the settings of a run, kernels of others included.

    Args:
        of_run: Settings by solver; what it leaves out is as in the YAML.
    """
    before = _OF_RUN.set(of_run)
    try:
        yield
    finally:
        _OF_RUN.reset(before)


def solver_class(name: str) -> type[Solver]:
    """Import the class of a solver.

    Raises:
        UnknownSolverError: No solver is called `name`.
        SolverError: The class cannot be imported or is no `Solver`.
        SkippedSolver: Its module needs a package that is not installed.
    """
    target = file_settings(name)[TARGET]
    module_name, _, class_name = target.rpartition(".")
    try:
        found = getattr(importlib.import_module(module_name), class_name)
    except ModuleNotFoundError as error:
        if error.name and not module_name.startswith(error.name):
            raise SkippedSolver(f"solver {name!r}: not installed: {error.name}") from error
        raise SolverError(f"solver {name!r}: cannot import {target}: {error}") from error
    except Exception as error:  # whatever a module of somebody else raises
        said = f"{type(error).__name__}: {error}"
        raise SolverError(f"solver {name!r}: cannot import {target}: {said}") from error
    if not (isinstance(found, type) and issubclass(found, Solver)):
        raise SolverError(f"solver {name!r}: {target} is not a subclass of baselines.Solver")
    return found


def skip(name: str, robot: Robot | None = None) -> str | None:
    """Say why a solver cannot run here (for `robot`, if given), or None if it can.

    Raises:
        UnknownSolverError: No solver is called `name`.
    """
    try:
        reason = solver_class(name).skip(robot)
        proposer = settings(name).get("proposer")  # a solver inside this one
        return skip(proposer, robot) if reason is None and proposer is not None else reason
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
        SolverError: `robot` is none.
        SkippedSolver: It cannot run here.
    """
    values = settings(name)
    del values[TARGET]
    from robots import Robot  # whoever has one has imported it

    if not isinstance(robot, Robot):
        raise SolverError(
            f"solver {name!r}: expected a robot, such as load_robot('panda'), got {shown(robot)}"
        )
    # Numbers of NumPy are as good as Python's, but no kernel is compiled for them.
    overrides = {k: v.item() if isinstance(v, np.generic) else v for k, v in overrides.items()}
    for key, value in overrides.items():
        check_setting(name, key, value)
    reason = skip(name, robot)
    if reason is not None:
        raise SkippedSolver(f"solver {name!r} is skipped for {robot.name}: {reason}")
    effective = {**values, **overrides}
    solver = solver_class(name)(robot, **effective)
    solver.name, solver.settings = name, effective
    if effective.get("weights") and not is_outside(name):
        solver.weights = Path(effective["weights"])
    return solver


def check_setting(name: str, key: str, value: object) -> None:
    """Refuse a setting that a solver does not have, and a value of another type.

    Raises:
        UnknownSolverError: No solver is called `name`.
        SettingError: It has no such setting, or one of another type.
    """
    values = {k: v for k, v in file_settings(name).items() if k != TARGET}
    if key not in values:
        raise SettingError(f"solver {name!r}: {unknown_name('setting', key, values)}")
    expected = setting_types(name).get(key, ())
    if value is None and values[key] is None:
        return
    if isinstance(value, int) and not isinstance(value, bool) and float in expected:
        return
    if expected and type(value) not in expected:
        kinds = " or ".join("null" if kind is NoneType else kind.__name__ for kind in expected)
        raise SettingError(
            f"solver {name!r}: setting {key!r} is a {kinds} (such as {values[key]!r}), got "
            f"{shown(value)}"
        )


def setting_types(name: str) -> dict[str, tuple[type, ...]]:
    """Return what types the settings of a solver may have.

    They are those of the parameters of its class, or of the class's bases where these take them;
    where a class only hands a setting on, or needs a package that is not installed, that of the
    value in the YAML. A value that is null there without a type may be anything: no types.

    Raises:
        UnknownSolverError: No solver is called `name`.
    """
    try:
        declared = _parameter_types(solver_class(name))
    except SolverError:
        declared = {}
    values = {key: value for key, value in file_settings(name).items() if key != TARGET}
    found = {key: () if value is None else (type(value),) for key, value in values.items()}
    return {key: declared.get(key, found[key]) for key in values}


@cache
def _parameter_types(owner: type[Solver]) -> dict[str, tuple[type, ...]]:
    """Plain types of the keyword parameters of a class and its bases, the class's own first."""
    found: dict[str, tuple[type, ...]] = {}
    for base in owner.__mro__:
        init = vars(base).get("__init__")
        if not inspect.isfunction(init):
            continue
        names_of = {k: v for k, v in init.__annotations__.items() if k not in ("robot", "return")}
        known = {"Robot": Any, **init.__globals__}
        for key, hint in get_type_hints(_Hints(names_of), known).items():
            kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
            if all(isinstance(kind, type) for kind in kinds):
                found.setdefault(key, kinds)
    return found


class _Hints:
    """Something with annotations, for `get_type_hints`: a function's own without its robot."""

    def __init__(self, annotations: dict[str, Any]) -> None:
        self.__annotations__ = annotations
