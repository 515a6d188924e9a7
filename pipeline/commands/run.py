"""Runs of stages: one or a sweep of runs, and how overrides and lists of a whole run combine."""

from __future__ import annotations

import re
from pathlib import Path

from pipeline.commands.arguments import names_in
from pipeline.config import (
    bench_lists,
    chosen,
    compose,
    group_choices,
    sweep,
    to_yaml,
    without_passwords,
)
from pipeline.data.files import write_text
from pipeline.errors import ConfigError
from pipeline.progress import LOGGER
from pipeline.settings import Config
from pipeline.solvers import is_neural
from pipeline.stages.graph import STEPS, Step
from pipeline.stages.running import run_stage
from robots.suggestions import unknown_name

SOLVERS = "evaluate.solvers"
ORIGINS = ("train.from", "detector.from")  # keys that `networks` of conf/bench.yaml sets


def run_once(name: str, overrides: list[str]) -> None:
    """Run one stage.

    Raises:
        ConfigError: An override that cannot be.
    """
    _run(name, compose(overrides))


def run_each(name: str, overrides: list[str]) -> None:
    """Run one stage for each combination of the values given, in a results folder each.

    Raises:
        ConfigError: An override that cannot be.
    """
    runs = sweep(overrides)
    profiles = {item for run in runs for item in run if item.startswith("profile=")}
    configs = [compose(run) for run in runs]  # a typo in the last run stops before the first
    for number, (run, config) in enumerate(zip(runs, configs, strict=True), start=1):
        folder = Path(config.results_dir) / "sweep" / run_name(run, with_profile=len(profiles) > 1)
        LOGGER.info("run %d of %d: %s", number, len(runs), without_passwords(" ".join(run)))
        config.results_dir = str(folder)
        write_text(folder.absolute() / "config.yaml", to_yaml(config))
        _run(name, config)


def split_lists(arguments: list[str]) -> tuple[dict[str, list[str]], list[str]]:
    """Split lists of conf/bench.yaml, the command's own in their place, from other overrides.

    `evaluate.solvers` narrows all lists of solvers; one that is in none of them joins its like.
    """
    bench = bench_lists(chosen_profile(arguments))
    lists = {key: list(value) for key, value in bench.items() if isinstance(value, list)}
    overrides = []
    for argument in arguments:
        key, _, value = argument.partition("=")
        if key in lists:
            lists[key] = names_in(value)
        elif key == SOLVERS:
            lists |= _narrowed(lists, names_in(value))
        else:
            overrides.append(argument)
    for name in lists["robots"]:
        if name not in group_choices("robot"):
            raise ConfigError(unknown_name("robot", name, group_choices("robot")))
    return lists, overrides


def _narrowed(lists: dict[str, list[str]], names: list[str]) -> dict[str, list[str]]:
    kinds = {name for step in STEPS.values() if (name := step.over.get("solver"))}
    narrow = {kind: [name for name in lists[kind] if name in names] for kind in kinds}
    for name in names:
        if not any(name in lists[kind] for kind in kinds):
            narrow["neural" if is_neural(name) else "numerical"].append(name)
    return narrow


def step_overrides(step: Step, axes: dict[str, str], typed: list[str]) -> list[str]:
    """A step's overrides and the user's, who may choose otherwise but for what makes the step."""
    fixed = {*step.without, *(["model"] if step.model else [])} & {*step.choices, "model"}
    kept = [item for item in typed if item.partition("=")[0] not in fixed]
    theirs = {item.partition("=")[0] for item in kept} & {*step.choices, *ORIGINS}
    own = [item for item in step.command(axes) if item.partition("=")[0] not in theirs]
    return [*kept, *own]


def chosen_profile(overrides: list[str]) -> str:
    """Return the profile that overrides choose, that of conf/config.yaml where they do not.

    Raises:
        ConfigError: There is no such profile.
    """
    typed = [item for item in overrides if item.startswith("profile=")]
    for name in (item.partition("=")[2] for item in typed):
        if name not in group_choices("profile"):
            raise ConfigError(unknown_name("profile", name, group_choices("profile")))
    return chosen(typed)["profile"]


def run_name(overrides: list[str], with_profile: bool = False) -> str:
    """Return a folder name that says what was overridden, such as ``robot=nico,seed=1``.

    The results folder is not named, nor is the profile unless it is swept: the name stands below
    both.
    """
    silent = ("results_dir=",) if with_profile else ("results_dir=", "profile=")
    shown = [without_passwords(item) for item in overrides if not item.startswith(silent)]
    return re.sub(r"[^\w=.,+-]", "_", ",".join(shown)) or "default"


def _run(name: str, config: Config) -> None:
    for path in run_stage(name, config):
        print(path)
