"""One stage from the command line; its help is answered without importing what a run needs."""

from __future__ import annotations

from pipeline.commands.arguments import command_parser


def stage(name: str, arguments: list[str]) -> int:
    """Run one stage, or with ``-m`` one run for each combination of the values given."""
    parser = command_parser(name, "", add_help=False)
    parser.add_argument("-h", "--help", action="store_true")
    parser.add_argument("-m", "--multirun", action="store_true")
    given = parser.takes_overrides().parse(arguments)
    if given.help:
        from pipeline.commands.kept_help import kept_help

        print(kept_help(name, given.overrides))
        return 0
    from pipeline.commands.run import run_each, run_once

    (run_each if given.multirun else run_once)(name, given.overrides)
    return 0
