"""`judge`: answers to a suite that somebody else's solver gave, judged as any solver's are."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

from pipeline import provenance
from pipeline.artifacts import exclusive
from pipeline.commands.arguments import command_parser
from pipeline.commands.suites import tables
from pipeline.config import compose
from pipeline.data.files import sha256
from pipeline.data.tables import write_table
from pipeline.errors import ConfigError
from pipeline.presentation.origin import origin_of
from pipeline.stages.inputs import artifacts, robot_of, suite_of
from pipeline.stages.running import make_suite
from pipeline.suites.judging import COLUMNS, SUFFIX, judge

PLAIN = re.compile(r"\w[\w.-]*")  # of a solver: it becomes the name of a file
DESCRIPTION = """\
judge FILE.parquet suite=near_singular robot=panda [--name mine] [profile=quick] [key=value ...]

Recomputes every error of the answers in FILE and prints the tables of the suite; no time is taken
on trust. `python -m pipeline suite` with the same keys writes the poses and says their checksum.
Columns of FILE:

"""


def judge_file(arguments: list[str]) -> int:
    """Judge one file; bad columns, another suite's checksum and poses of no suite are refused."""
    lines = "\n".join(f"  {name:<15} {what}" for name, what in COLUMNS.items())
    parser = command_parser("judge", DESCRIPTION + lines)
    parser.add_argument("file", type=Path, metavar="FILE", help="Parquet, one row a pose")
    parser.add_argument("--name", help="of the solver in tables; that of the file where left out")
    options = parser.takes_overrides().parse(arguments)
    label = options.name or options.file.stem
    if not PLAIN.fullmatch(label):
        raise ConfigError(f"--name is letters, digits, '_', '-' and '.', not {label!r}")
    config = compose(options.overrides)
    make_suite(config)
    robot, suite = robot_of(config), suite_of(config)
    name = label + SUFFIX
    judged = judge(options.file, name, suite, robot, config.evaluate, config.seed)
    path = artifacts(config).judge(robot.name, suite.name, label)
    facts = {
        **provenance.made_by(),
        **provenance.signature(config.profile),
        "seed": config.seed,
        "suite": suite.name,
        "suite_version": suite.version,
        "suite_checksum": suite.checksum,
        "answers_sha256": sha256(options.file),
    }
    with exclusive(path):
        write_table(path, judged.rows, facts)
    command = shlex.join(["python", "-m", "pipeline", "judge", *arguments])
    origin = origin_of(command, [facts], config.profile)
    for text in tables({(robot.name, suite.name, name): judged.rows}, config.report, origin):
        print(text)
    for note in judged.notes:
        print(note)
    print(path)
    return 0
