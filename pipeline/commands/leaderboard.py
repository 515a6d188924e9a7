"""`leaderboard`: judge files that somebody sends and write the lines that are committed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from pipeline.commands.arguments import command_parser
from pipeline.config import compose
from pipeline.errors import ConfigError, PipelineError
from pipeline.leaderboard.boards import machine_name, put, read_boards
from pipeline.leaderboard.errors import LeaderboardError
from pipeline.leaderboard.line import line_of
from pipeline.leaderboard.schema import FIELDS, WORD
from pipeline.leaderboard.submission import SIDECAR, TIME, Submission, read_submission
from pipeline.locations import results
from pipeline.settings import Config
from pipeline.stages.inputs import robot_of, suite_of
from pipeline.stages.running import make_suite
from pipeline.suites.generators import Suite
from pipeline.suites.judging import COLUMNS
from robots import Robot

FOLDER = "leaderboard"  # below results/
DESCRIPTION = """\
leaderboard add FILE.parquet [...] [--machine NAME] [--folder FOLDER] [key=value ...]
leaderboard check [--folder FOLDER]
leaderboard columns

`add` judges each file again and puts its line into FOLDER/MACHINE/SUITE_ROBOT.csv, in place of an
earlier one of the same solver. A file is either raw rows of `python -m pipeline suites`, or answers
with a YAML file of the same name beside them. `check` reads every committed line; `columns` says
what each means.

Columns of answers:
"""


@dataclass(frozen=True)
class Destination:
    """Where lines go: the folder of boards; the machine's name, None for one of its own."""

    folder: Path
    machine: str | None


def leaderboard(arguments: list[str]) -> int:
    """Run one of the actions."""
    answers = {**COLUMNS, TIME: "wall time of the call with that one pose [us]; may be left out"}
    text = f"{DESCRIPTION}{_listed(answers)}\n\nKeys of the YAML file:\n{_listed(SIDECAR)}"
    parser = command_parser("leaderboard", text)
    parser.add_argument("action", choices=("add", "check", "columns"), metavar="ACTION")
    parser.add_argument("--machine", help="name of its folder; from processor and threads if none")
    parser.add_argument("--folder", type=Path, help=f"of the boards; results/{FOLDER} if none")
    parser.add_argument("files", nargs="*", metavar="FILE or key=value")
    options = parser.parse(arguments)
    folder = options.folder or results() / FOLDER
    if options.machine is not None and not WORD.fullmatch(options.machine):
        raise ConfigError(f"--machine is letters, digits, '_', '-', '.', not {options.machine!r}")
    if options.action == "add":
        return _add(options.files, Destination(folder, options.machine))
    if options.files:
        raise PipelineError(f"leaderboard {options.action} takes no {options.files[0]!r}")
    return _columns() if options.action == "columns" else _check(folder)


def add_file(path: Path, to: Destination, overrides: Sequence[str] = ()) -> tuple[Path, list[str]]:
    """Judge one file and write its line.

    Args:
        path: The file.
        to: Where the line goes.
        overrides: Of the run that has the suite, besides robot, suite, profile and seed.

    Returns:
        The board, and a sentence for each thing that is wrong with the answers.

    Raises:
        PipelineError: The file is not what is expected, or its board is of another suite.
    """
    sent = read_submission(path)
    run = _run((*sent.overrides(), *overrides))
    line, notes = line_of(sent, run.suite, run.robot, run.config.evaluate, run.config.report)
    return put(to.folder, to.machine or _machine_of(sent), line), notes


@dataclass(frozen=True)
class _Run:
    """What files are answers to."""

    config: Config
    suite: Suite
    robot: Robot


@cache
def _run(overrides: tuple[str, ...]) -> _Run:
    """Make the suite of a run where there is none; files of many solvers share it."""
    config = compose(overrides)
    make_suite(config)
    return _Run(config, suite_of(config), robot_of(config))


def _add(words: Sequence[str], to: Destination) -> int:
    overrides = [word for word in words if "=" in word]
    files = [Path(word) for word in words if "=" not in word]
    if not files:
        raise PipelineError("leaderboard add names no file; see leaderboard --help")
    for path in files:
        board, notes = add_file(path, to, overrides)
        print(*notes, f"{path} -> {board}", sep="\n")
    return 0


def _check(folder: Path) -> int:
    lines = read_boards(folder)
    if lines.empty:
        raise LeaderboardError(f"there is no line below {folder}; write some with leaderboard add")
    boards = lines.groupby(["machine", "robot", "suite"]).ngroups
    print(f"{len(lines)} lines of {boards} boards in {folder}: all as they should be")
    return 0


def _columns() -> int:
    print(_listed({name: field.meaning for name, field in FIELDS.items()}))
    print("  within_<t>us        how many poses are solved by calls of at most so many us")
    return 0


def _machine_of(sent: Submission) -> str:
    return machine_name(str(sent.facts["processor"]), int(sent.facts["threads"]))


def _listed(meanings: dict[str, str]) -> str:
    return "\n".join(f"  {name:<19} {meaning}" for name, meaning in meanings.items())
