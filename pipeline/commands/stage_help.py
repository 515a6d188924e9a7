"""`<stage> --help`: the keys that a stage reads, with the values and comments of their YAML."""

from __future__ import annotations

import ast
import textwrap
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import yaml

from pipeline.config import chosen, compose, group_choices, sources, values
from pipeline.key_comments import key_comments
from pipeline.settings import Config
from pipeline.solvers import is_neural
from pipeline.stages.graph import STAGES, STEPS, Stage
from robots import available_robots

ALWAYS = ("seed", "results_dir")  # keys of every stage
COLUMN, WIDTH = 40, 110  # where comments begin, and where lines end


def stage_help(name: str, overrides: Sequence[str] = ()) -> str:
    """Return what `--help` prints: what a stage does, its choices, and its keys as YAML.

    Args:
        name: Of a stage of the graph.
        overrides: Of the run in question; another model has other values.

    Raises:
        ConfigError: An override that cannot be.
    """
    stage, config = STAGES[name], compose(overrides)
    made_first = [f"`{each}`" for each in stage.inputs]
    return "\n".join(
        [
            f"python -m pipeline {name} [key=value ...] [-m]",
            "",
            _docstring(stage.module),
            "",
            *([_before(stage, made_first), ""] if made_first else []),
            f"Keys that it reads, as they are for: {' '.join(overrides) or 'no overrides'}",
            "",
            *_choices(stage, overrides),
            *_yaml(read_values(stage, config, overrides), comments(overrides)),
        ]
    )


def read_values(stage: Stage, config: Config, overrides: Sequence[str]) -> dict[str, Any]:
    """Return the values that a stage reads, nested as in the configuration.

    Of the solvers those that the run loads, and of what there is for each robot the run's own.
    """
    every = values(overrides)
    found: dict[str, Any] = {}
    for path in (*ALWAYS, *stage.groups):
        value, place = every, found
        *above, last = path.split(".")
        for part in above:
            value, place = value[part], place.setdefault(part, {})
        place[last] = value[last]
    if "solver" in found:
        names = {*stage.solver_names(config), *_kernels(stage)} & {*found["solver"]}
        found["solver"] = {name: found["solver"][name] for name in sorted(names)}
    return _of_robot(found, config.robot.name)


def comments(overrides: Sequence[str]) -> dict[str, str]:
    """Return the comment of each key of a run, from the file where its value stands."""
    comments_by_key: dict[str, str] = {}
    for source in sources(overrides):
        prefix = f"{source.package}." if source.package else ""
        found = key_comments(source.path).items()
        comments_by_key |= {f"{prefix}{key}": text for key, text in found if text}
    return comments_by_key


def _kernels(stage: Stage) -> set[str]:
    """Solvers that other solvers of the stage refine with, whose settings count as well."""
    named = (name for step in STEPS.values() if step.stage == stage.name for name in step.settings)
    return {name for name in named if not is_neural(name)}


def _of_robot(node: Any, robot: str) -> Any:
    if not isinstance(node, dict):
        return node
    per_robot = len(node) > 1 and set(node) <= set(available_robots())
    kept = {key: value for key, value in node.items() if not per_robot or key == robot}
    return {key: _of_robot(value, robot) for key, value in kept.items()}


def _docstring(module: str) -> str:
    """The docstring of a module, without importing what it needs."""
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    return ast.get_docstring(ast.parse(Path(spec.origin).read_text(encoding="utf-8"))) or ""


def _before(stage: Stage, made_first: list[str]) -> str:
    return (
        f"It reads what {', '.join(made_first)} left; a missing dataset or network is made first, "
        "by keys that those stages read."
    )


def _choices(stage: Stage, overrides: Sequence[str]) -> Iterator[str]:
    """One line for each group that the stage reads: its choice, and the others."""
    groups = {group.partition(".")[0] for group in stage.groups} | {"profile", "experiment"}
    for group, choice in chosen(overrides).items():
        if group in groups:
            yield f"{f'{group}={choice}':<{COLUMN - 1}} # {' | '.join(group_choices(group))}"
    yield ""


def _yaml(node: dict[str, Any], comments_by_key: dict[str, str], path: str = "") -> Iterator[str]:
    depth = path.count(".")
    for key, value in node.items():
        nested = isinstance(value, dict) and value
        text = f"{'  ' * depth}{key}:" + ("" if nested else f" {_flow(value)}")
        yield from _commented(text, comments_by_key.get(f"{path}{key}", ""))
        if nested:
            yield from _yaml(value, comments_by_key, f"{path}{key}.")


def _flow(value: Any) -> str:
    text = yaml.safe_dump(value, default_flow_style=True, width=10**6, allow_unicode=True)
    return text.removesuffix("\n...\n").strip()


def _commented(text: str, comment: str) -> Iterator[str]:
    if not comment:
        yield text
        return
    first, *more = textwrap.wrap(comment, WIDTH - COLUMN - 2)
    yield f"{text:<{COLUMN - 1}} # {first}"
    yield from (f"{'':<{COLUMN}}# {line}" for line in more)
