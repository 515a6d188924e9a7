"""`site`: report, paper, protocols, studies and leaderboard as pages that open from disk."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from pipeline.commands.arguments import command_parser, split_keys
from pipeline.commands.claims import closing_rows, closing_tables_of
from pipeline.commands.leaderboard import FOLDER as BOARDS
from pipeline.config import compose
from pipeline.errors import PipelineError
from pipeline.leaderboard.boards import read_boards
from pipeline.locations import need_checkout, published_results
from pipeline.presentation.published import read_published
from pipeline.provenance import commit
from pipeline.reporting.data import ReportData
from pipeline.reporting.report import load
from pipeline.settings import Config
from pipeline.site.boards import leaderboard_page
from pipeline.site.build import Site, write_site
from pipeline.site.comparison import comparison_table
from pipeline.site.content import (
    PROJECT,
    THIS_RUN,
    Closing,
    chapter_pages,
    paper_page,
    start_page,
    studies_page,
)
from pipeline.site.files import claim
from pipeline.site.parts import Page, Section, Sheet
from pipeline.stages.inputs import artifacts

DIR, COMPARE = "site.dir", "compare"  # keys of the command
TITLE = "cycleik-bench"
DESCRIPTION = """\
site [profile=quick] [site.dir=FOLDER] [compare=OTHER/RESULTS] [key=value ...]

Writes results/PROFILE/site (or FOLDER): pages that open from disk, with all they need beside them.
They show what the results folder has and what is committed; compare=... adds a page that sets its
numbers beside those of another results folder, and marks differences beyond the intervals.
"""


def site(arguments: list[str]) -> int:
    """Write the pages and print the path of the first."""
    options = command_parser("site", DESCRIPTION).takes_overrides().parse(arguments)
    own, overrides = split_keys(options.overrides, (DIR, COMPARE))
    root = need_checkout("the site")
    config = compose(overrides)
    folder = Path(own.get(DIR) or artifacts(config).root / "site").absolute()
    other = _other(own.get(COMPARE))
    claim(folder)
    print(write_site(_site(config, root / "results", folder, other), folder))
    return 0


def _other(name: str | None) -> Path | None:
    if name is not None and not Path(name).is_dir():
        raise PipelineError(f"compare={name}: there is no such folder; expected a results folder")
    return None if name is None else Path(name)


def _site(config: Config, results: Path, folder: Path, other: Path | None) -> Site:
    data = _load(config, artifacts(config).root)
    numbers, claims = closing_rows(results)
    closing = Closing(numbers, claims, closing_tables_of(numbers, claims))
    boards = replace(leaderboard_page(read_boards(results / BOARDS), config.report), kicker=PROJECT)
    pages = [
        start_page(data, closing, config.report.title),
        paper_page(data, closing, results, folder),
        *chapter_pages(data, folder),
        boards,
        studies_page(results, folder),
    ]
    if other is not None:
        theirs = _load(config, other)
        if theirs.results.empty:
            raise PipelineError(f"compare={other}: no stage has left anything in that folder")
        pages.append(_comparison(data, theirs, config))
    footer = [
        f"Written by `python -m pipeline site profile={config.profile}` at commit {commit()}. "
        "Every table names what made its rows and has them as CSV.",
        "The code is under the MIT licence. Please cite the paper if you use it.",
    ]
    return Site(TITLE, config.profile, pages, footer)


def _load(config: Config, root: Path) -> ReportData:
    return load(root, read_published(published_results()), config.report, config.profile)


def _comparison(first: ReportData, second: ReportData, config: Config) -> Page:
    names = (first.results.folder.name, second.results.folder.name)
    if names[0] == names[1]:
        names = (str(first.results.folder), str(second.results.folder))
    table = comparison_table(first, second, names, config.report)
    lead = f"A is {first.results.folder}, B is {second.results.folder}."
    return Page("compare", "Comparison", lead, [Section("numbers", "", [Sheet(table)])], THIS_RUN)
