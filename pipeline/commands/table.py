"""`table`: Table II or III of the paper from the raw rows on disk, in seconds."""

from __future__ import annotations

from pathlib import Path

from pipeline.commands.arguments import command_parser
from pipeline.config import compose
from pipeline.locations import published_results, results
from pipeline.presentation.published import read_published
from pipeline.reporting.single import MAKERS, paper_table

PREFERRED = ("paper", "quick")  # profiles whose rows are looked for, the published scale first
DESCRIPTION = """\
table table2 [results_dir=results/slow] [report.not_found=nan]

Prints the table and writes it as CSV, Markdown and LaTeX to tables/ of the results folder that its
rows come from: results/paper where that has any, else results/quick, or what results_dir names.
"""


def table(arguments: list[str]) -> int:
    """Make one table; the first argument is its name."""
    parser = command_parser("table", DESCRIPTION)
    parser.add_argument("table", choices=tuple(MAKERS), help="of the paper")
    options = parser.takes_overrides().parse(arguments)
    name, overrides = options.table, options.overrides
    config = compose(overrides)
    folders = [results() / profile for profile in PREFERRED]
    if any(override.startswith(("results_dir=", "profile=")) for override in overrides):
        folders = [Path(config.results_dir)]
    published = read_published(published_results())
    made, folder = paper_table(name, folders, published, config.report)
    paths = made.write(folder / "tables")
    print(made.to_markdown())
    for path in paths:
        print(path)
    return 0
