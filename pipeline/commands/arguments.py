"""Arguments of commands: argparse, with bad input as one sentence in place of a page of usage."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Mapping, Sequence
from typing import Any, NoReturn

from pipeline.errors import PipelineError

PROGRAM = "python -m pipeline"


class CommandParser(argparse.ArgumentParser):
    """A parser whose errors are `PipelineError`: one sentence and the usage.

    Options may stand before, between and after overrides.
    """

    def parse(self, arguments: Sequence[str]) -> argparse.Namespace:
        """Parse all arguments; ``--help`` prints and raises `SystemExit`.

        Raises:
            PipelineError: An option that does not exist, or an argument too few or too many.
        """
        parsed, rest = self.parse_known_intermixed_args(arguments)
        for argument in rest:
            if argument.startswith("-"):
                from robots.suggestions import unknown_name

                options = [name for action in self._actions for name in action.option_strings]
                raise PipelineError(unknown_name("option", argument, options))
            self.error(f"unexpected argument '{argument}'")
        return parsed

    def takes_overrides(self) -> CommandParser:
        """Take overrides of the configuration, as ``overrides``, after all other arguments."""
        self.add_argument(
            "overrides",
            nargs="*",
            metavar="key=value",
            help="overrides of the configuration, such as robot=nico or profile=smoke",
        )
        return self

    def error(self, message: str) -> NoReturn:
        """Raise the problem as one sentence.

        Raises:
            PipelineError: Always.
        """
        raise PipelineError(f"{message}; {' '.join(self.format_usage().split())}")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse a value that is not among the choices, with the nearest one."""
        if action.choices is not None and value not in action.choices:
            from robots.suggestions import unknown_name

            kind = str(action.metavar or action.dest)
            raise PipelineError(unknown_name(kind, str(value), map(str, action.choices)))


def command_parser(command: str, description: str, add_help: bool = True) -> CommandParser:
    """Make the parser of a command.

    Args:
        command: Its name.
        description: What it does, printed by ``--help``.
        add_help: Whether ``--help`` prints it; a command may take that option itself.
    """
    return CommandParser(
        prog=f"{PROGRAM} {command}",
        description=description,
        formatter_class=argparse.RawDescriptionHelpFormatter,
        allow_abbrev=False,
        add_help=add_help,
    )


def split_keys(arguments: Sequence[str], keys: Collection[str]) -> tuple[dict[str, str], list[str]]:
    """Split keys of a command from overrides of the configuration.

    Args:
        arguments: As they were typed.
        keys: Of the command.

    Returns:
        Values by key, and the other arguments.

    Raises:
        PipelineError: A key of the command has no value.
    """
    own, overrides = {}, []
    for argument in arguments:
        key, _, value = argument.partition("=")
        if key not in keys:
            overrides.append(argument)
        elif value:
            own[key] = value
        else:
            raise PipelineError(f"{key} has no value; expected {key}=...")
    return own, overrides


def with_defaults(arguments: Sequence[str], defaults: Mapping[str, str]) -> list[str]:
    """Return overrides, before them the defaults of a command for keys that none of them sets."""
    typed = {argument.partition("=")[0] for argument in arguments}
    return [*(f"{key}={value}" for key, value in defaults.items() if key not in typed), *arguments]


def count(key: str, text: str) -> int:
    """Return the whole number from 1 that a key was given.

    Raises:
        PipelineError: It is none.
    """
    if not text.isdigit() or int(text) < 1:
        raise PipelineError(f"{key} must be a whole number from 1, got {text!r}")
    return int(text)


def flag(key: str, text: str) -> bool:
    """Return whether a key was given true or false.

    Raises:
        PipelineError: It is neither.
    """
    if text.lower() not in ("true", "false"):
        raise PipelineError(f"{key} takes true or false, got {text}")
    return text.lower() == "true"


def names_in(text: str) -> list[str]:
    """Return the names of a list such as ``[panda,nico]``, with or without brackets."""
    return [name.strip() for name in text.strip("[]").split(",") if name.strip()]
