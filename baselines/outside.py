"""Solvers that live outside the checkout: by `module:Class`, or by an entry point of a package.

A package names its solver in its own pyproject.toml

    [project.entry-points."cycleik_bench.solvers"]
    mine = "my_package.solver:MySolver"

and it is called `mine` everywhere. The class is a subclass of `baselines.Solver`; its settings are
the keyword parameters of its `__init__` beside the robot, and since there is no YAML to own their
values, each needs a default. Names of conf/solver come first.
"""

from __future__ import annotations

import importlib
import inspect
import re
from functools import cache
from importlib.metadata import entry_points
from typing import Any

from baselines.errors import SolverError

GROUP = "cycleik_bench.solvers"  # of entry points
TARGET = re.compile(r"[A-Za-z_][\w.]*:[A-Za-z_]\w*")


@cache
def installed() -> dict[str, str]:
    """Return the solvers of installed packages: name to ``module:Class``."""
    return {entry.name: entry.value for entry in entry_points(group=GROUP)}


def target_of(name: str) -> str | None:
    """Return ``module.Class`` of a solver outside the checkout; None for a name that is none.

    Args:
        name: ``module:Class``, or the name of an entry point.
    """
    target = name if TARGET.fullmatch(name) else installed().get(name)
    return None if target is None else target.replace(":", ".")


def default_settings(target: str) -> dict[str, Any]:
    """Return the defaults of the keyword parameters of a class.

    Args:
        target: ``module.Class``. One that cannot be imported has no settings here; whoever loads
            it is told why.

    Raises:
        SolverError: A parameter has no default.
    """
    module, _, name = target.rpartition(".")
    try:
        found = inspect.signature(getattr(importlib.import_module(module), name)).parameters
    except Exception:  # whatever a module of somebody else raises
        return {}
    many = (inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL)
    named = [each for each in list(found.values())[1:] if each.kind not in many]
    bare = [each.name for each in named if each.default is each.empty]
    if bare:
        raise SolverError(
            f"{target}: settings {', '.join(bare)} have no default; a solver outside the checkout "
            "has no YAML that could give them one"
        )
    return {each.name: each.default for each in named}
