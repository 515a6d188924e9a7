"""`suites`: solvers on all suites of hard poses of a robot, and the tables of what came out."""

from __future__ import annotations

import shlex

from pipeline.commands.arguments import command_parser
from pipeline.commands.choices import split_choices
from pipeline.config import compose
from pipeline.data.tables import read_metadata, read_table
from pipeline.evaluation.config import row_name
from pipeline.presentation.origin import Origin, origin_of
from pipeline.progress import LOGGER
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.suite_measures import Rows
from pipeline.reporting.topics.suites import TABLES
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts
from pipeline.stages.running import run_stage
from pipeline.suites.drawing import NoProblemsError

NAME = "suites"  # key of the command: which suites
DESCRIPTION = """\
suites [robot=panda] [suites=[at_limits,warm]] [evaluate.solvers=[lm,placo]] [key=value ...]

Evaluates every solver of evaluate.solvers on every suite of conf/suite, or on those of
suites=[...], and prints the tables. Rows of the same question are kept: killed and called again it
continues. A suite that a robot cannot have (at_limits without limits) is left out and named.
"""


def suites_of(arguments: list[str]) -> int:
    """Run the suites of one robot."""
    options = command_parser(NAME, DESCRIPTION).takes_overrides().parse(arguments)
    names, overrides = split_choices("suite", options.overrides)
    configs = [
        compose(["evaluate.keep=true", *overrides, f"suite={name}"]) for name in names
    ]  # a typo stops before the first suite
    answered = []
    for config in configs:
        try:
            run_stage("evaluate-suite", config)
            answered.append(config.suite.name)
        except NoProblemsError as error:
            LOGGER.warning("suite %s is left out: %s", config.suite.name, error)
    if not answered:
        raise NoProblemsError(
            f"{configs[0].robot.name} has none of these suites: {', '.join(names)}"
        )
    for text in _tables_of(configs[0], answered, arguments):
        print(text)
    return 0


def _tables_of(config: Config, names: list[str], arguments: list[str]) -> list[str]:
    """Tables of the rows that a run has just made or kept, as Markdown."""
    robot, folders = config.robot.name, artifacts(config)
    labels = {row_name(name, config.evaluate.pinned) for name in config.evaluate.solvers}
    paths = [
        folders.evaluate_suite(robot, name, label) for name in names for label in sorted(labels)
    ]
    rows: Rows = {(robot, path.parent.name, path.stem): read_table(path) for path in paths}
    command = shlex.join(["python", "-m", "pipeline", "suites", *arguments])
    origin = origin_of(command, [read_metadata(path) for path in paths], config.profile)
    return tables(rows, config.report, origin)


def tables(rows: Rows, config: ReportConfig, origin: Origin) -> list[str]:
    """Return the tables of raw rows of suites that have any rows, as Markdown.

    Args:
        rows: By robot, suite and solver.
        config: Success and confidence.
        origin: What made the rows.
    """
    made = [make(rows, config) for make in TABLES]
    for table in made:
        table.origin = origin
    return [table.to_markdown() for table in made if table.rows]
