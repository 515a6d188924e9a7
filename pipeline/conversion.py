"""What is composed, as dataclasses: every key known, every type and value checked."""

from __future__ import annotations

import copy
import pickle
import re
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, make_dataclass
from functools import cache, lru_cache
from typing import Any, cast, get_type_hints

from omegaconf import MISSING, DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from baselines import SolverError, registry
from pipeline.errors import ConfigError
from pipeline.learning.registry import config_class
from pipeline.settings import Config
from pipeline.suites.config import suite_class

NAMES_IN_YAML = {"from": "source"}  # train.from, detector.from: no Python keyword names a field
SOLVER = "solver"  # group and field of the settings of all solvers


def solver_settings() -> dict[str, dict[str, Any]]:
    """The settings of each solver as its file has them, without the class that they are for."""
    every = {name: registry.file_settings(name) for name in registry.names()}
    return {
        name: {key: value for key, value in values.items() if key != registry.TARGET}
        for name, values in every.items()
    }


def to_dataclass(raw: DictConfig) -> Config:
    """Convert a composed configuration.

    Raises:
        ConfigError: A key, a type or a value that cannot be, or one that is missing.
    """
    try:
        container = cast(dict[str, Any], OmegaConf.to_container(raw, resolve=True))
        solvers = container.pop(SOLVER)
        _check_solvers(solvers)
        values = renamed(container, NAMES_IN_YAML)
        kinds = {
            "model": config_class(values["model"]["kind"]),
            "suite": suite_class(values["suite"]["generator"]),
        }
        classes = {**_group_classes(), **kinds}
        plain = {name: value for name, value in values.items() if name not in classes}
        made, missing = {}, list[str]()
        for name, group in classes.items():
            made[name], lacks = _converted(group, name, pickle.dumps(values[name]))
            missing += lacks
        own, lacks = _converted(_plain_class(), "", pickle.dumps(plain))
        if missing := sorted([*missing, *lacks]):
            raise ConfigError(f"no value for {', '.join(missing)}: set it, or choose a profile")
        return Config(**vars(own), **copy.deepcopy(made), solver=solvers)
    except ConfigError:
        raise
    except (OmegaConfBaseException, ValueError) as error:
        raise ConfigError(first_line(error)) from error


@cache
def _group_classes() -> dict[str, type]:
    """Fields of the configuration that are groups, with their classes."""
    hints = get_type_hints(Config).items()
    return {name: cast(type, hint) for name, hint in hints if is_dataclass(hint)}


@cache
def _plain_class() -> type:
    """A class of the other fields, but for those that OmegaConf has nothing to say of."""
    hints = get_type_hints(Config)
    names = [each.name for each in fields(Config) if each.name not in _group_classes()]
    wanted = [name for name in names if name not in (SOLVER, "weights")]
    return make_dataclass("Config", [(name, hints[name], MISSING) for name in wanted])


@lru_cache(maxsize=512)
def _converted(group: type, name: str, values: bytes) -> tuple[Any, tuple[str, ...]]:
    """Convert a group to its dataclass, once for the same values: most runs share most groups.

    Args:
        group: The dataclass.
        name: Of the group; empty for the root.
        values: Pickled.

    Returns:
        The object, to be copied before it is changed, and the keys that lack a value.

    Raises:
        ConfigError: A key or a type that does not fit.
    """
    prefix = f"{name}." if name else ""
    try:
        merged = OmegaConf.unsafe_merge(OmegaConf.structured(group), pickle.loads(values))
        missing = tuple(f"{prefix}{key}" for key in OmegaConf.missing_keys(merged))
        return (None if missing else OmegaConf.to_object(merged)), missing
    except OmegaConfBaseException as error:
        key = getattr(error, "full_key", None) or ""
        line = first_line(error)
        raise ConfigError(f"{prefix}{key}: {line}" if key else line) from error


def _check_solvers(solvers: dict[str, dict[str, Any]]) -> None:
    """Refuse a setting that differs from the solver's file and is of another type.

    Raises:
        ConfigError: There is one.
    """
    for name, own in solver_settings().items():
        for key, value in solvers[name].items():
            if value != own[key] or type(value) is not type(own[key]):
                try:
                    registry.check_setting(name, key, value)
                except SolverError as error:
                    raise ConfigError(f"{SOLVER}.{name}.{key}: {error}") from error


def renamed(container: dict[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    """The configuration with keys of train and detector under other names."""
    groups = {
        group: {names.get(key, key): value for key, value in container[group].items()}
        for group in ("train", "detector")
    }
    return {**container, **groups}


def first_line(error: BaseException) -> str:
    """The sentence of a Hydra or OmegaConf message, without its context lines."""
    line = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
    return re.sub(r"\s+", " ", line).rstrip(".")
