"""`zoo`: compact networks for many arms of others, and where their seeds pay."""

from __future__ import annotations

import shlex
from dataclasses import fields
from pathlib import Path

import pandas as pd

from pipeline.artifacts import exclusive
from pipeline.commands.arguments import command_parser, names_in, split_keys
from pipeline.config import compose
from pipeline.errors import ConfigError, PipelineError
from pipeline.presentation.origin import origin_of
from pipeline.presentation.style import save, styled
from pipeline.progress import LOGGER
from pipeline.zoo.arms import Arm, MissingArmError, ZooConfig, read_zoo
from pipeline.zoo.reporting import NAME, figure_of, table_of
from pipeline.zoo.study import row_of
from robots import RobotError
from robots.suggestions import unknown_name

ARMS = "arms"
DESCRIPTION = """\
zoo [arms=[ur5,iiwa]] [minutes=3] [poses=5000] [train=1000000] [results_dir=results/slow]

Takes the arms of conf/zoo.yaml out of installed packages, trains the compact network for each and
measures the descent of lm from home and from the network's best hypothesis. Prints the table and
writes it with a figure to zoo/ of the results folder, where robots and weights lie as well. Arms
that are done are kept and a stopped training goes on: killed and called again it continues.
"""


def zoo(arguments: list[str]) -> int:
    """Run the zoo."""
    options = command_parser(NAME, DESCRIPTION).takes_overrides().parse(arguments)
    sizes = [field.name for field in fields(ZooConfig)]
    given, overrides = split_keys(options.overrides, (ARMS, *sizes))
    wanted = given.pop(ARMS, "")
    config, arms = read_zoo(given)
    chosen = _chosen(arms, wanted)
    run = compose(overrides)
    folder = Path(run.results_dir) / NAME
    rows, notes = [], []
    for number, arm in enumerate(chosen, 1):
        LOGGER.info("arm %d of %d: %s", number, len(chosen), arm.name)
        try:
            rows.append(row_of(arm, folder, config))
        except (MissingArmError, RobotError) as error:
            LOGGER.warning("%s is left out: %s", arm.name, error)
            notes.append(f"Left out: {arm.name} ({error}).")
    if not rows:
        raise PipelineError(f"the zoo has no arm that could be measured: {' '.join(notes)}")
    frame = pd.DataFrame(rows)
    table = table_of(frame, config, notes)
    table.origin = origin_of(shlex.join(["python", "-m", "pipeline", NAME, *arguments]), rows)
    with exclusive(folder / NAME), styled():
        paths = table.write(folder) + save(figure_of(frame), folder, NAME, run.report.dpi)
    print(table.to_markdown())
    for path in paths:
        print(path)
    return 0


def _chosen(arms: dict[str, Arm], wanted: str) -> list[Arm]:
    """Return the arms that are named, all where none is.

    Raises:
        ConfigError: The zoo has no arm of a name.
    """
    names = names_in(wanted)
    for name in names:
        if name not in arms:
            raise ConfigError(unknown_name("arm", name, list(arms)))
    return [arms[name] for name in names or arms]
