"""Which files of conf/ shape what a step leaves, found by following their defaults lists."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import TYPE_CHECKING, Any

from pipeline.config import compose, group_choices
from pipeline.data.files import read_yaml
from pipeline.locations import CONF_DIR
from pipeline.stages.graph import STAGES, STEPS, Step
from robots import available_robots

if TYPE_CHECKING:
    from pipeline.settings import Config

WITHOUT_EFFECT = ("engine",)  # groups that say where a stage runs, not what it makes
WHOLE: tuple[str, ...] = ()  # every key of a file counts
ROBOT, MODEL, PROFILE = "${item.robot}", "${model}", "${profile}"  # as dvc.yaml fills them in
TUNE = "${tune}"  # likewise
Parameters = dict[str, tuple[str, ...]]


def parameters(step: Step) -> Parameters:
    """Return the keys of conf/ that shape what a step leaves, by file below the checkout.

    What differs from run to run stands in the names of files as DVC fills it in, such as
    ``${item.robot}``. No keys stand for all keys of a file.
    """
    found: Parameters = {"conf/config.yaml": WHOLE}
    groups = read_groups(step)
    for name, _, part in (group.partition(".") for group in groups if group != "solver"):
        for file, keys in _files(name, _choice(name, step), part):
            known = found.get(file, keys)
            found[file] = WHOLE if WHOLE in (known, keys) else tuple(sorted({*known, *keys}))
    if "solver" in groups:
        found |= {f"conf/solver/{name}.yaml": WHOLE for name in _solvers(step)}
    if (profiled := _profiled(groups)) is not None:
        found[f"conf/profile/{PROFILE}.yaml"] = profiled
    return found


def read_groups(step: Step) -> tuple[str, ...]:
    """Return the groups whose values shape what a step leaves.

    Not among them are those that only say where it runs, those that its inputs were made with, and
    the network of a step that neither trains one nor reads one.
    """
    stage = STAGES[step.stage]
    inputs = {STEPS[name].stage for name in step.inputs}
    networks = "train" in inputs or "train" in stage.groups
    dropped = {*WITHOUT_EFFECT, *step.without, *inputs, *(() if networks else ("model",))}
    return tuple(group for group in stage.groups if group not in dropped)


def _choice(group: str, step: Step) -> str:
    if group == "robot":
        return ROBOT
    if group in ("model", "train"):  # a recipe goes by the name of its model
        return step.model or MODEL
    if group == "tune":
        return TUNE
    return step.choices.get(group) or _defaults()[group]


@cache
def _defaults() -> dict[str, str]:
    entries = read_yaml(CONF_DIR / "config.yaml")["defaults"]
    return {
        group: choice for entry in entries if entry != "_self_" for group, choice in entry.items()
    }


def _files(group: str, choice: str, part: str = "") -> Iterator[tuple[str, tuple[str, ...]]]:
    """Yield the file of a choice, its keys that count, and the same of the files that it takes in.

    Args:
        group: Folder below conf/.
        choice: Name of a file there, or what DVC fills in.
        part: Only what is at or below this key of the group; empty for all of it.
    """
    file = f"conf/{group}/{choice}.yaml"
    if "$" in choice:  # DVC fills in one of several, so what any of them takes in counts
        yield file, (part,) if part else WHOLE
        for name in group_choices(group):
            for inner_group, inner_choice, package in _nested(group, name):
                if not part or package == part or package.startswith(f"{part}."):
                    yield from _files(inner_group, inner_choice)
        return
    if not part or part in read_yaml(CONF_DIR / group / f"{choice}.yaml"):
        yield file, (part,) if part else WHOLE
    for inner_group, inner_choice, package in _nested(group, choice):
        if not part or package == part or package.startswith(f"{part}."):
            yield from _files(inner_group, inner_choice)


def _nested(group: str, choice: str) -> Iterator[tuple[str, str, str]]:
    """Yield group, choice and package of each entry of a file's defaults list."""
    for entry in read_yaml(CONF_DIR / group / f"{choice}.yaml").get("defaults", []):
        if entry == "_self_":
            continue
        place, name = next(iter(entry.items())) if isinstance(entry, dict) else ("", entry)
        if place.startswith("override "):
            continue
        inner, _, package = place.partition("@")
        below = inner.removeprefix("/") if inner.startswith("/") else f"{group}/{inner}".rstrip("/")
        package = (package or inner).replace("_here_", "").replace("/", ".")
        per_robot = set(group_choices(below)) <= set(available_robots())
        for each in name if isinstance(name, list) else [name]:
            yield below, ROBOT if per_robot else str(each), package


def _solvers(step: Step) -> list[str]:
    """Names of the solvers whose settings count: of the axis, or of any profile's configuration."""
    fixed = list(step.settings)
    if "solver" in step.over:
        return ["${item.solver}", *fixed]
    stage = STAGES[step.stage]
    named = {solver for config in _profiles() for solver in stage.solver_names(config)}
    return sorted({*named, *fixed})


@cache
def _profiles() -> list[Config]:
    return [compose([f"profile={name}"]) for name in group_choices("profile")]


def _profiled(groups: tuple[str, ...]) -> tuple[str, ...] | None:
    """Keys by which profiles set these groups; all where one sets a group that another does not."""
    profiles = [
        read_yaml(CONF_DIR / "profile" / f"{name}.yaml") for name in group_choices("profile")
    ]
    has = {group: [_has(values, group) for values in profiles] for group in groups}
    some = tuple(sorted(group for group in groups if any(has[group])))
    if {*groups} & {root for values in profiles for root in _chosen_inside(values)}:
        some = (*some, "defaults")
        has["defaults"] = [_has(values, "defaults") for values in profiles]
    if not some:
        return None
    return some if all(all(has[group]) for group in some) else WHOLE


def _chosen_inside(profile: Any) -> Iterator[str]:
    """Groups inside which a profile chooses a file: plan by `override /motion@plan.motion`."""
    for entry in profile.get("defaults", []):
        for place in entry if isinstance(entry, dict) else ():
            if "@" in place:
                yield place.partition("@")[2].split(".")[0]


def _has(values: Any, key: str) -> bool:
    """Whether a mapping has a key such as ``grasp.physics``."""
    for part in key.split("."):
        if not isinstance(values, dict) or part not in values:
            return False
        values = values[part]
    return True
