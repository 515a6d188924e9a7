"""`suites`: solvers on all suites of hard poses of a robot, and the tables of what came out."""

from __future__ import annotations

import shlex
from pathlib import Path

from pipeline.artifacts import Artifacts
from pipeline.commands.arguments import command_parser
from pipeline.config import compose, group_choices
from pipeline.data.tables import read_metadata, read_table
from pipeline.errors import ConfigError, PipelineError
from pipeline.evaluation.config import row_name
from pipeline.presentation.origin import Origin, origin_of
from pipeline.progress import LOGGER
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.topics.suites import Rows, leaders, suites, tracking, unreachable
from pipeline.settings import Config
from pipeline.stages.inputs import artifacts
from pipeline.stages.running import run_stage
from pipeline.suites.drawing import NoProblemsError
from robots.suggestions import unknown_name

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
    names, overrides = _names(options.overrides)
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


def _names(arguments: list[str]) -> tuple[list[str], list[str]]:
    """Split the suites of the command from overrides of the stage."""
    names, overrides = group_choices("suite"), []
    for argument in arguments:
        key, _, value = argument.partition("=")
        if key == NAME:
            names = [name.strip() for name in value.strip("[]").split(",") if name.strip()]
        elif key in ("suite", "suite.name"):
            raise PipelineError(f"suites takes suites=[...], got {argument}")
        else:
            overrides.append(argument)
    for name in names:
        if name not in group_choices("suite"):
            raise ConfigError(unknown_name("suite", name, group_choices("suite")))
    if not names:
        raise ConfigError(f"suites=[] names no suite; expected some of {group_choices('suite')}")
    return names, overrides


def _of_suite(path: Path, folders: Artifacts) -> bool:
    """Say whether rows are of the suite as it is now; those of an earlier one are named."""
    suite = folders.find(
        folders.suite(path.parent.parent.name, path.parent.name).relative_to(folders.root)
    )
    same = (
        suite is not None
        and read_metadata(path)["suite_checksum"] == read_metadata(suite)["suite_checksum"]
    )
    if not same:
        LOGGER.warning("%s is left out: its rows are of another version or size of it", path)
    return same


def _tables_of(config: Config, names: list[str], arguments: list[str]) -> list[str]:
    """Tables of the rows of a run as Markdown, those of the given suites."""
    robot, folders = config.robot.name, artifacts(config)
    labels = {row_name(name, config.evaluate.pinned) for name in config.evaluate.solvers}
    places = [folders.evaluate_suite(robot, name, "").parent for name in names]
    paths = [path for place in places for path in sorted(place.glob("[!.]*.parquet"))]
    paths = [path for path in paths if path.stem in labels and _of_suite(path, folders)]
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
    made = [make(rows, config) for make in (suites, unreachable, tracking, leaders)]
    for table in made:
        table.origin = origin
    return [table.to_markdown() for table in made if table.rows]
