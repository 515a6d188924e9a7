"""The solvers of a run, and the code that their answers depend on."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import baselines
from baselines import Solver
from baselines.registry import settings, using
from pipeline.closure import source_tree
from pipeline.data.files import sha256
from pipeline.errors import MissingArtifactError
from pipeline.learning.registry import declared_modules, kinds_in
from pipeline.solvers import is_neural
from robots import Robot

if TYPE_CHECKING:
    from pipeline.settings import Config


def solver_of(name: str, robot: Robot, config: Config) -> Solver:
    """Make a solver for a run; a neural one gets the weights that were found for the run.

    Raises:
        MissingArtifactError: `pipeline.stages.running` has not looked for its weights.
    """
    with using(config.solver):
        if not is_neural(name) or settings(name)["weights"]:
            return baselines.load(name, robot)
        if name in config.weights:
            return baselines.load(name, robot, weights=config.weights[name])
    raise MissingArtifactError(
        f"there are no weights for solver '{name}' of {robot.name} in this run; train with: "
        f"python -m pipeline train robot={robot.name} profile={config.profile}"
    )


def code_of(module: str, solvers: Mapping[str, Iterable[str]], config: Config) -> str:
    """Return a digest of the code behind rows: of a module and of the solvers that answer.

    Args:
        module: Name of the module that makes the rows.
        solvers: Names of the solvers, by what they are for; only a YAML names the file of each.
        config: Of the run, whose settings may name a solver inside another one.
    """
    names = [name for each in solvers.values() for name in each]
    with using(config.solver):
        modules = solver_modules(names)
    known = source_tree().modules()
    outside = [_outside_digest(name) for name in modules if name not in known]
    digest = source_tree().digest(module, *(name for name in modules if name in known))
    return "-".join([digest, *outside])


def _outside_digest(module: str) -> str:
    """Digest of the file of a module outside the checkout; what that imports is not in it."""
    spec = find_spec(module)
    if spec is None or spec.origin is None or not Path(spec.origin).is_file():
        return module
    return sha256(Path(spec.origin))[:16]


def solver_modules(names: Iterable[str]) -> tuple[str, ...]:
    """Return the modules of solvers by name, of those that their settings name, of networks."""
    found: dict[str, str] = {}
    waiting = list(names)
    while waiting:
        name = waiting.pop()
        if name not in found:
            values = settings(name)
            found[name] = values["_target_"].rpartition(".")[0]
            waiting += [text for text in _texts(values) if text in baselines.names()]
    kinds = {kind for module in found.values() for kind in kinds_in(module)}
    networks = {module for kind in kinds for module in declared_modules(kind)}
    return tuple(sorted({*found.values(), *networks}))


def _texts(value: Any) -> Iterable[str]:
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for item in value:
            yield from _texts(item)
    elif isinstance(value, str):
        yield value
