"""`protocols`: the same solvers by everyone's protocol, the tables of what came out, one figure."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from pathlib import Path

from pipeline.artifacts import exclusive
from pipeline.commands.arguments import command_parser
from pipeline.commands.choices import split_choices
from pipeline.config import compose
from pipeline.data.tables import read_metadata, read_table
from pipeline.evaluation.config import row_name
from pipeline.presentation.origin import origin_of
from pipeline.presentation.style import save, styled
from pipeline.reporting.results import ProtocolKey
from pipeline.reporting.topics.protocols import Rows, agreement, bumps, rankings, turned_pairs
from pipeline.settings import Config
from pipeline.stages.evaluate_protocol import left_out, rows_name
from pipeline.stages.inputs import artifacts
from pipeline.stages.running import run_stage

NAME = "protocols"  # key of the command: which protocols
FIGURE = "protocols"
DESCRIPTION = """\
protocols [robot=panda] [protocols=[trac_ik,ikflow]] [protocol.solvers=[lm,placo]] [key=value ...]

Evaluates every solver of protocol.solvers by every protocol of conf/protocol, or by those of
protocols=[...], prints how they rank, how the rankings agree and what turned them, and writes
tables and figure to protocols/<robot>. Rows of the same question are kept: killed and called again
it continues.
"""


def protocols_of(arguments: list[str]) -> int:
    """Run the protocols of one robot."""
    options = command_parser(NAME, DESCRIPTION).takes_overrides().parse(arguments)
    names, overrides = split_choices("protocol", options.overrides)
    configs = [
        compose(["evaluate.keep=true", *overrides, f"protocol={name}"]) for name in names
    ]  # a typo stops before the first protocol
    for config in configs:
        run_stage("evaluate-protocol", config)
    for path in _write(configs, arguments):
        print(path)
    return 0


def _write(configs: list[Config], arguments: list[str]) -> list[Path]:
    """Print tables of the robot's rows, and write them and the figure."""
    config = configs[0]
    folder = artifacts(config).protocols(config.robot.name)
    paths = _tables_of_rows(configs)
    facts = {path: read_metadata(path) for path in paths.values()}
    rows: Rows = {key: (read_table(path), facts[path]) for key, path in paths.items()}
    command = shlex.join(["python", "-m", "pipeline", "protocols", *arguments])
    origin = origin_of(command, list(facts.values()), config.profile)
    notes = [f"Left out: {name} ({why})." for name, why in left_out(config).items()]
    written = []
    with exclusive(folder):
        for table in (rankings(rows), agreement(rows), turned_pairs(rows)):
            table.origin = origin
            table.notes += notes
            if table.rows:
                print(table.to_markdown())
                written += table.write(folder)
        with styled():
            written += save(bumps(rows), folder, FIGURE, config.report.dpi)
    return written


def _tables_of_rows(configs: list[Config]) -> Mapping[ProtocolKey, Path]:
    """Files of raw rows of a run, by robot, protocol, solver and batch size."""
    config = configs[0]
    robot, folders = config.robot.name, artifacts(config)
    skipped = left_out(config)
    able = [name for name in config.protocol.solvers if name not in skipped]
    found = {}
    for each in configs:
        for solver in (row_name(name, config.evaluate.pinned) for name in able):
            place = folders.evaluate_protocol(robot, each.protocol.name, solver)
            for size in each.protocol.calls():
                key = (robot, each.protocol.name, solver, size)
                found[key] = place / rows_name(size)
    return found
