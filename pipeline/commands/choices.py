"""Commands that run a stage for several choices of a group, such as ``suites=[...]``."""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.commands.arguments import names_in
from pipeline.config import group_choices
from pipeline.errors import ConfigError
from robots.suggestions import unknown_name


def split_choices(group: str, arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Split the choices that a command is for from the overrides of its stage.

    Args:
        group: Of conf/, such as ``suite``; the key of the command is its plural.
        arguments: As they were typed.

    Returns:
        Names of the choices, all where none is named, and the other arguments.

    Raises:
        ConfigError: No choice, an unknown one, or one that is named as a stage does.
    """
    key, known = f"{group}s", group_choices(group)
    names, overrides = known, []
    for argument in arguments:
        given, _, value = argument.partition("=")
        if given == key:
            names = names_in(value)
        elif given in (group, f"{group}.name"):
            raise ConfigError(f"{key} takes {key}=[...], got {argument}")
        else:
            overrides.append(argument)
    for name in names:
        if name not in known:
            raise ConfigError(unknown_name(group, name, known))
    if not names:
        raise ConfigError(f"{key}=[] names no {group}; expected some of {known}")
    return names, overrides
