"""Composition: YAML and overrides in, a checked `Config` out, or one clear sentence."""

from __future__ import annotations

import pickle
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from pathlib import Path
from threading import Lock
from typing import Any, NamedTuple, cast

import yaml
from hydra import compose as hydra_compose
from hydra import initialize_config_dir
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from hydra._internal.defaults_list import DefaultsList
from hydra.core.config_store import ConfigStore
from hydra.core.global_hydra import GlobalHydra
from hydra.core.override_parser.overrides_parser import OverridesParser
from hydra.core.override_parser.types import Glob, Override
from hydra.errors import HydraException
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from baselines import SolverError, registry
from pipeline.containers import to_dict
from pipeline.conversion import (
    NAMES_IN_YAML,
    SOLVER,
    first_line,
    renamed,
    solver_settings,
    to_dataclass,
)
from pipeline.data.files import Document, read_yaml
from pipeline.errors import ConfigError
from pipeline.kept_yaml import keep_parsed_files
from pipeline.locations import CONF_DIR
from pipeline.settings import Config
from robots.locations import home
from robots.suggestions import unknown_name

ROOT = "config"  # conf/config.yaml, where composition starts
PASSWORD_OF_USER = re.compile(r"(://[^:/@\s]*:)\S*@")
PASSWORD_OF_QUERY = re.compile(r"([?&]password=)[^&\s]*")
EVERY = "every"  # name of the one group of which a run has every file, not one: that of the solvers
DATA = (["tune", "space"], ["grasp", "objects"])  # mappings of names that a run may add to
OWNERS = ("profile", "experiment")  # groups that own keys of others, and explain what they set

_WORD = re.compile(r"[\w.-]+")
COMPOSING = Lock()  # Hydra holds its state once for all threads of a process


def compose(overrides: Sequence[str] = ()) -> Config:
    """Compose conf/ with overrides and check every key, type and value.

    Args:
        overrides: Hydra overrides, for example ``["robot=nico", "train.learning_rate=1.0e-4"]``.

    Returns:
        The configuration as dataclasses. Its results folder is absolute: one among the overrides is
        relative to where the user stands, that of conf/config.yaml to the checkout.

    Raises:
        ConfigError: An unknown key or choice, a wrong type, or a value that cannot be.
    """
    overrides = _sayable(overrides)
    parsed = _parse(overrides)
    for override in parsed:
        if override.is_sweep_override():
            raise ConfigError(
                f"'{override.input_line}' names several values: add -m to run each of them, "
                "or write a list in brackets: key=[a,b]"
            )
    _check_names(parsed)
    raw = _compose_raw(parsed)
    typed = any(override.key_or_group == "results_dir" for override in parsed)
    if Path(raw.results_dir) != Path():
        raw.results_dir = str((Path.cwd() if typed else home()) / raw.results_dir)
    return to_dataclass(raw)


def sweep(overrides: Sequence[str]) -> list[list[str]]:
    """Expand swept overrides to one list of plain overrides for each run, in order.

    ``["robot=panda,nico", "seed=range(2)"]`` gives four lists.

    Raises:
        ConfigError: An override that Hydra's grammar does not take.
    """
    axes: list[list[str]] = []
    for override in _parse(_sayable(overrides)):
        key = override.get_key_element()
        if isinstance(pattern := override.value(), Glob):
            axes.append([f"{key}={name}" for name in _matching(override, pattern)])
        elif override.is_discrete_sweep():
            axes.append([f"{key}={value}" for value in override.sweep_string_iterator()])
        elif override.is_sweep_override():
            raise ConfigError(f"'{override.input_line}' is an open interval: list its values")
        else:
            axes.append([cast(str, override.input_line)])
    return [list(run) for run in product(*axes)]


def _sayable(overrides: Sequence[str]) -> list[str]:
    """Quote words with letters outside ASCII, such as robots' names: Hydra's grammar has none."""
    said = []
    for override in overrides:
        key, equals, value = override.partition("=")
        if not value.isascii() and not {"'", '"'} & set(value):
            value = _WORD.sub(lambda word: word[0] if word[0].isascii() else f"'{word[0]}'", value)
        said.append(key + equals + value)
    return said


def _matching(override: Override, pattern: Glob) -> list[str]:
    group = override.key_or_group
    if not (CONF_DIR / group).is_dir():
        raise ConfigError(
            f"'{override.input_line}': glob() stands for the files of a group such as robot; "
            f"list the values of {group}"
        )
    found: list[str] = pattern.filter(group_choices(group))
    if not found:
        valid = ", ".join(group_choices(group))
        raise ConfigError(f"'{override.input_line}' matches no {group}. Valid: {valid}")
    return found


@dataclass(frozen=True)
class Source:
    """A file under conf/ that a run is composed of.

    Attributes:
        path: The file.
        package: Where in the configuration its keys stand, such as ``train`` or ``plan.motion``;
            empty for the root.
    """

    path: Path
    package: str


def sources(overrides: Sequence[str] = ()) -> list[Source]:
    """Return the files that a run is composed of, in the order in which later ones win.

    Raises:
        ConfigError: A choice of a group that does not exist.
    """
    found = _defaults(overrides).defaults
    read = [
        Source(CONF_DIR / f"{item.config_path}.yaml", item.package or "")
        for item in found
        if item.config_path not in (None, f"{SOLVER}/{EVERY}")
        and not item.config_path.startswith("hydra/")
    ]
    solvers = [
        Source(registry.FOLDER / f"{name}.yaml", f"{SOLVER}.{name}") for name in registry.names()
    ]
    return [*solvers, *read]


def chosen(overrides: Sequence[str] = ()) -> dict[str, str]:
    """Return the choice of each group of a run, in the order of conf/config.yaml.

    Raises:
        ConfigError: A choice of a group that does not exist.
    """
    known = _defaults(overrides).overrides.known_choices
    entries = read_yaml(CONF_DIR / f"{ROOT}.yaml")["defaults"]
    groups = [group for entry in entries if isinstance(entry, dict) for group in entry]
    return {group: str(known[group]) for group in groups if group != SOLVER and known.get(group)}


def values(overrides: Sequence[str] = ()) -> dict[str, Any]:
    """Return the values of a run as conf/ and the overrides have them, before they are checked."""
    return cast(
        dict[str, Any], OmegaConf.to_container(_compose_raw(_parse(overrides)), resolve=True)
    )


def _defaults(overrides: Sequence[str]) -> DefaultsList:
    with _hydra():
        loader = GlobalHydra.instance().config_loader()
        return loader.compute_defaults_list(ROOT, list(overrides), RunMode.RUN)


def bench_lists(profile: str = "") -> dict[str, Any]:
    """Return conf/bench.yaml: the profile and the lists that `all` and `make reproduce` run.

    Args:
        profile: Whose lists; that of conf/bench.yaml where left out. Those of
            conf/bench_<profile>.yaml stand in place of the others.

    Raises:
        FileError: It is no YAML, or lacks a key.
    """
    path = CONF_DIR / "bench.yaml"
    plain = read_yaml(path)
    own = _own_lists(profile or str(plain.get("profile")))
    return Document(path, {**plain, **(read_yaml(own) if own.exists() else {})})


def has_own_lists(profile: str) -> bool:
    """Whether a profile has lists in place of those of conf/bench.yaml."""
    return _own_lists(profile).exists()


def _own_lists(profile: str) -> Path:
    return CONF_DIR / f"bench_{profile}.yaml"


def group_choices(group: str) -> list[str]:
    """Return the names of the YAML files of a group, such as ``robot``."""
    return sorted(path.stem for path in (CONF_DIR / group).glob("*.yaml"))


def to_yaml(config: Config) -> str:
    """Return the configuration as YAML, keys in the order of the schema, without passwords."""
    in_yaml = renamed(to_dict(config), {v: k for k, v in NAMES_IN_YAML.items()})
    return without_passwords(OmegaConf.to_yaml(in_yaml))


def without_passwords(text: str) -> str:
    """Return a text with asterisks for the passwords of the addresses in it.

    Args:
        text: Such as ``tune.storage=postgresql://user:password@host/database``.
    """
    return PASSWORD_OF_QUERY.sub(r"\1***", PASSWORD_OF_USER.sub(r"\1***@", text))


def _parse(overrides: Sequence[str]) -> list[Override]:
    try:
        return OverridesParser.create().parse_overrides(list(overrides))
    except HydraException as error:
        raise ConfigError(
            f"an override must read key=value, for example train.epochs=3 ({first_line(error)})"
        ) from error


def _compose_raw(parsed: Sequence[Override]) -> DictConfig:
    """What Hydra composes: files by the choices of groups, once, and then the keys in a copy.

    Hydra does the same in this order, but reads and merges some forty files every time.
    """
    groups, keys = _groups_and_keys(parsed)
    raw = cast(DictConfig, pickle.loads(_base(groups, _state()).pickled))
    with _our_errors():
        ConfigLoaderImpl._apply_overrides_to_config(keys, raw)
    return raw


class _Base(NamedTuple):
    """A configuration with choices of groups only; never changed."""

    raw: DictConfig
    pickled: bytes  # a copy is read from it five times as fast as OmegaConf makes one


@lru_cache(maxsize=64)
def _base(groups: tuple[str, ...], state: tuple[object, ...]) -> _Base:
    """Compose what choices of groups select.

    Args:
        groups: Overrides that choose files.
        state: Of the files below conf/, which may change while a process runs.
    """
    with _hydra():
        raw = hydra_compose(config_name=ROOT, overrides=list(groups))
    return _Base(raw, pickle.dumps(raw))


def _state() -> tuple[object, ...]:
    """What changes when a file below conf/ does: folder, names, times and sizes."""
    seen: list[object] = [CONF_DIR]
    for path in (*sorted(CONF_DIR.rglob("*.yaml")), *sorted(registry.FOLDER.glob("*.yaml"))):
        entry = path.stat()
        seen.append((path, entry.st_mtime_ns, entry.st_size))
    return tuple(seen)


def _groups_and_keys(parsed: Sequence[Override]) -> tuple[tuple[str, ...], list[Override]]:
    """Split overrides into those that choose a file of a group and those of keys, as Hydra does."""
    groups, keys = [], []
    for override in parsed:
        is_group = (CONF_DIR / override.key_or_group).is_dir()
        if is_group and not isinstance(override.value(), dict):
            groups.append(cast(str, override.input_line))
        else:
            keys.append(override)
    return tuple(groups), keys


@contextmanager
def _hydra() -> Iterator[None]:
    """Hydra with conf/ and all solvers, for one thread at a time; its errors become ours."""
    with (
        _our_errors(),
        COMPOSING,
        initialize_config_dir(config_dir=str(CONF_DIR), version_base="1.3"),
    ):
        ConfigStore.instance().store(EVERY, solver_settings(), SOLVER)
        keep_parsed_files()
        yield


@contextmanager
def _our_errors() -> Iterator[None]:
    try:
        yield
    except yaml.YAMLError as error:
        raise ConfigError(
            f"a file under conf/ is not YAML: {' '.join(str(error).split())}"
        ) from error
    except (HydraException, OmegaConfBaseException) as error:
        raise ConfigError(_no_recipe(str(error)) or first_line(error)) from error
    except SolverError as error:
        raise ConfigError(str(error)) from error


def _no_recipe(message: str) -> str:
    """What to do about a model without a recipe of its name; empty for any other message."""
    found = re.search(r"Could not find 'train/(\w+)'", message)
    if found is None:
        return ""
    name = found[1]
    return (
        f"model={name} has no recipe conf/train/{name}.yaml: write one, or name another one with "
        f"train=...: {', '.join(group_choices('train'))}"
    )


def _check_names(parsed: Sequence[Override]) -> None:
    """Refuse unknown choices and keys before Hydra does, with the valid ones."""
    groups, keys = _groups_and_keys(parsed)
    for override in parsed:
        key, value = override.key_or_group, override.value()
        if not (CONF_DIR / key).is_dir():
            continue
        if key == SOLVER:
            raise ConfigError(
                f"'{override.input_line}': a run has the settings of all solvers, as "
                f"solver.<name>.<key>; which of them it takes, keys such as evaluate.solvers say"
            )
        if key == OWNERS[1] and value is None:
            continue
        if str(value) not in group_choices(key):
            raise ConfigError(unknown_name(key, str(value), group_choices(key)))
    base = _base(groups, _state()).raw
    for override in keys:
        if override.is_delete():
            raise ConfigError(f"'{override.input_line}': keys cannot be removed, only set")
        adds = override.is_add() or override.is_force_add()
        _check_key(base, override.key_or_group, adds)


def _check_key(base: DictConfig, key: str, adds: bool) -> None:
    node: Any = base
    walked: list[str] = []
    for part in key.split("."):
        keys = list(node.keys()) if isinstance(node, DictConfig) else []
        if part not in keys:
            if adds and walked[:2] in DATA:
                return  # a new entry is the user's right
            where = "key" if not walked else f"key in {'.'.join(walked)}:"
            raise ConfigError(f"{key}: " + unknown_name(where, part, [str(name) for name in keys]))
        walked.append(part)
        node = node._get_node(part) if OmegaConf.is_missing(node, part) else node[part]
