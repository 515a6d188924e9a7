"""The report: every table and figure that the rows on disk allow, and one page that shows them."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from pipeline.data.files import write_json, write_text
from pipeline.errors import MissingArtifactError
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.figure_plan import draw_figures
from pipeline.reporting.metrics_file import headline_metrics
from pipeline.reporting.page import Page, render
from pipeline.reporting.published import read_published
from pipeline.reporting.report_data import load, make_tables
from pipeline.reporting.results import STAGES
from pipeline.reporting.table import Table

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
    tables = make_tables(data)
    _remove_others(paths.tables, [path for table in tables for path in table.write(paths.tables)])
    illustrations = draw_figures(data, paths.figures)
    pictures = [picture.path for picture in illustrations]
    _remove_others(paths.figures, [*pictures, *(p.with_suffix(".pdf") for p in pictures)])
    write_json(paths.metrics, headline_metrics(data.results, data.summary))
    page = Page(data.results, config, tables, illustrations)
    write_text(paths.html, render(page))
    return paths


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


def _remove_others(folder: Path, kept: Collection[Path]) -> None:
    """Remove what an earlier report wrote and this one did not."""
    for path in folder.glob("*"):
        if path.suffix in WRITTEN and path not in kept:
            path.unlink()
