"""The report: every table and figure that the rows on disk allow, and one page that shows them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd

from pipeline.artifacts import exclusive
from pipeline.data.files import write_json, write_text
from pipeline.errors import MissingArtifactError
from pipeline.presentation.naming import ordered_robots
from pipeline.presentation.origin import Origin, origin_of
from pipeline.presentation.published import Published, read_published
from pipeline.presentation.style import save, styled
from pipeline.presentation.table import Table
from pipeline.reporting.chapters import CHAPTERS, TOPICS
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.data import ReportData, Topic
from pipeline.reporting.metrics_file import headline_metrics
from pipeline.reporting.page import Illustration, Section, render
from pipeline.reporting.results import STAGES, Results, read_results
from pipeline.reporting.summary import summarise
from pipeline.reporting.topics.pairs import compare_solvers
from pipeline.reporting.topics.seeding import adjusted, same_budget, seed_effects

WRITTEN = (".csv", ".md", ".tex", ".png", ".pdf")  # what a report leaves in tables/ and figures/


@dataclass(frozen=True)
class ReportPaths:
    """Where a report lies.

    Attributes:
        tables: Folder of the tables (CSV, Markdown, LaTeX).
        figures: Folder of the figures (PNG, PDF).
        html: The page that shows all of it.
        metrics: Numbers for `dvc metrics`.
    """

    tables: Path
    figures: Path
    html: Path
    metrics: Path


def make_report(
    results_dir: Path, published: Path, config: ReportConfig, profile: str = ""
) -> ReportPaths:
    """Write tables, figures, report.html and metrics.json from what a results folder holds.

    What is missing is named in the report and is no error, unless all of it is. The same rows give
    the same files; tables and figures of an earlier report that have no rows any more are removed.

    Args:
        results_dir: Results folder of a profile or of a run; written into as well.
        published: `results/published_results.csv`.
        config: Policies, confidence, looks.
        profile: Profile of the run; the report of a smoke run warns of its numbers.

    Raises:
        PublishedError: The published numbers cannot be read.
        MissingArtifactError: No stage has left anything there.
    """
    data = load(results_dir, read_published(published), config, profile)
    if data.results.empty:
        raise MissingArtifactError(
            f"no stage has left anything in {results_dir}: check results_dir and profile, or run "
            f"one of {', '.join(STAGES)} first, such as: python -m pipeline evaluate"
        )
    paths = ReportPaths(
        tables=results_dir / "tables",
        figures=results_dir / "figures",
        html=results_dir / "report.html",
        metrics=results_dir / "metrics.json",
    )
    with exclusive(paths.html):
        _write(data, config, paths)
    return paths


def _write(data: ReportData, config: ReportConfig, paths: ReportPaths) -> None:
    """Write all that belongs to a report, and remove what no longer does."""
    sections = [
        Section(
            chapter,
            make_tables(data, chapter.topics),
            draw_figures(data, chapter.topics, paths.figures),
        )
        for chapter in CHAPTERS
    ]
    tables = [path for each in sections for t in each.tables for path in t.write(paths.tables)]
    _remove_others(paths.tables, tables)
    pictures = [figure.path for each in sections for figure in each.figures]
    _remove_others(paths.figures, [*pictures, *(p.with_suffix(".pdf") for p in pictures)])
    write_json(paths.metrics, headline_metrics(data.results, data.summary))
    write_text(paths.html, render(data.results, config, sections))


def make_table(results_dir: Path, published: Path, config: ReportConfig, name: str) -> Table:
    """Make one table, such as ``table2_numerical_comparison``, without drawing anything.

    Raises:
        ValueError: There is no table of that name; the message lists the names.
    """
    tables = make_tables(load(results_dir, read_published(published), config))
    found = [table for table in tables if table.name == name]
    if not found:
        raise ValueError(f"no table '{name}'; there are {', '.join(t.name for t in tables)}")
    return found[0]


def load(
    results_dir: Path, published: Published, config: ReportConfig, profile: str = ""
) -> ReportData:
    """Read the results and summarise their raw rows, one file at a time."""
    results = read_results(results_dir, profile)
    lines = [
        summarise(rows, config).assign(network=results.evaluated[key].get("network") or None)
        for key, rows in results.evaluate.items()
    ]
    summary = pd.concat(lines, ignore_index=True) if lines else pd.DataFrame()
    pairs = []
    for robot in ordered_robots(results.robots):
        mine = [results.evaluate[robot, solver] for solver in results.solvers(robot)]
        if len(mine) > 1:
            pairs.append(compare_solvers(pd.concat(mine, ignore_index=True), config))
    effects = _effects(results, config)
    return ReportData(results, published, summary, _joined(pairs), effects, config, profile)


def make_tables(data: ReportData, topics: Sequence[Topic] = TOPICS) -> list[Table]:
    """Make every table of some topics that has rows, in the order of the report."""
    made = [(make(data), topic) for topic in topics for make in topic.tables]
    return [
        replace(table, origin=table.origin or _origin(data, topic))
        for table, topic in made
        if table.rows
    ]


def _origin(data: ReportData, topic: Topic) -> Origin:
    """What made the rows of a topic's tables."""
    results = data.results
    cards = [card for stage in topic.stages for card in results.cards.get(stage, [])]
    named = {card.get("profile") for card in results.evaluated.values()} - {None}
    profile = data.profile or (str(*named) if len(named) == 1 else "")
    chosen = f" profile={profile}" if profile else ""
    return origin_of(f"python -m pipeline report{chosen}", cards, profile)


def draw_figures(data: ReportData, topics: Sequence[Topic], folder: Path) -> list[Illustration]:
    """Draw every figure of some topics that has rows, and say under each how to read it."""
    illustrations = []
    with styled():
        for plot in (plot for topic in topics for plot in topic.plots):
            if plot.needs(data):
                png, _ = save(plot.draw(data), folder, plot.name, data.config.dpi)
                illustrations.append(Illustration(plot.name, plot.caption_for(data), png))
    return illustrations


def _effects(results: Results, config: ReportConfig) -> pd.DataFrame:
    """Pair rows from a neural seed with those from home; a pair of other budgets is noted."""
    found = []
    for (robot, solver, seeder), (rows, facts) in results.seeded.items():
        place = f"evaluate/{robot}/{solver}.parquet"
        if (robot, solver) not in results.evaluate:
            results.notes.append(f"There is no {place} to compare the seeds of {seeder} with.")
        elif not same_budget(results.evaluated[robot, solver], facts):
            results.notes.append(f"{place} has another budget or settings than from {seeder}.")
        else:
            found.append(seed_effects(results.evaluate[robot, solver], rows, config))
    return adjusted(_joined(found))


def _joined(frames: Iterable[pd.DataFrame]) -> pd.DataFrame:
    kept = [frame for frame in frames if len(frame)]
    return pd.concat(kept, ignore_index=True) if kept else pd.DataFrame()


def _remove_others(folder: Path, kept: Collection[Path]) -> None:
    """Remove what an earlier report wrote and this one did not."""
    for path in folder.glob("*"):
        if path.suffix in WRITTEN and path not in kept:
            path.unlink()
