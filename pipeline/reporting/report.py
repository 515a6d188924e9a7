"""The report: every table and figure that the rows on disk allow, and one page that shows them."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from pipeline.data.files import write_json, write_text
from pipeline.errors import MissingArtifactError
from pipeline.reporting import figures_benchmark as benchmark
from pipeline.reporting import figures_experiment as experiment
from pipeline.reporting.comparison import compare_solvers
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.metrics_file import headline_metrics
from pipeline.reporting.naming import ordered_robots
from pipeline.reporting.page import Illustration, Page, render
from pipeline.reporting.published import Published, read_published
from pipeline.reporting.results import STAGES, Results, read_results
from pipeline.reporting.style import save, styled
from pipeline.reporting.summary import summarise
from pipeline.reporting.table import Table
from pipeline.reporting.tables_benchmark import neural_comparison, numerical_comparison
from pipeline.reporting.tables_solvers import comparisons, precision, timing
from pipeline.reporting.tables_training import datasets, hyperparameters, training
from pipeline.reporting.tables_trials import grasping, planner

MAPPED = "cycleik"  # the solver whose precision is shown over the workspace
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


@dataclass(frozen=True)
class Material:
    """What tables and figures are made of."""

    results: Results
    published: Published
    summary: pd.DataFrame
    pairs: pd.DataFrame
    config: ReportConfig


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
    material = gather(results_dir, read_published(published), config, profile)
    if material.results.empty:
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
    tables = make_tables(material)
    _remove_others(paths.tables, [path for table in tables for path in table.write(paths.tables)])
    illustrations = draw_figures(material, paths.figures)
    pictures = [picture.path for picture in illustrations]
    _remove_others(paths.figures, [*pictures, *(p.with_suffix(".pdf") for p in pictures)])
    write_json(paths.metrics, headline_metrics(material.results, material.summary))
    page = Page(material.results, config, tables, illustrations)
    write_text(paths.html, render(page))
    return paths


def make_table(results_dir: Path, published: Path, config: ReportConfig, name: str) -> Table:
    """Make one table, such as ``table2_numerical_comparison``, without drawing anything.

    Raises:
        ValueError: There is no table of that name; the message lists the names.
    """
    tables = make_tables(gather(results_dir, read_published(published), config))
    found = [table for table in tables if table.name == name]
    if not found:
        raise ValueError(f"no table '{name}'; there are {', '.join(t.name for t in tables)}")
    return found[0]


def gather(
    results_dir: Path, published: Published, config: ReportConfig, profile: str = ""
) -> Material:
    """Read the results and summarise their raw rows, one file at a time."""
    results = read_results(results_dir, profile)
    lines = [summarise(rows, config) for rows in results.evaluate.values()]
    summary = pd.concat(lines, ignore_index=True) if lines else pd.DataFrame()
    pairs = []
    for robot in ordered_robots(results.robots):
        mine = [results.evaluate[robot, solver] for solver in results.solvers(robot)]
        if len(mine) > 1:
            pairs.append(compare_solvers(pd.concat(mine, ignore_index=True), config))
    compared = [frame for frame in pairs if len(frame)]
    joined = pd.concat(compared, ignore_index=True) if compared else pd.DataFrame()
    return Material(results, published, summary, joined, config)


def make_tables(material: Material) -> list[Table]:
    """Make every table that has rows, in the order of the report."""
    results, published, summary = material.results, material.published, material.summary
    made = [
        numerical_comparison(summary, published),
        neural_comparison(summary, published),
        precision(summary, material.config),
        timing(summary),
        comparisons(material.pairs, material.config),
        hyperparameters(results, published),
        datasets(results),
        training(results),
        planner(results, published),
        grasping(results, published, material.config),
    ]
    return [table for table in made if table.rows]


def draw_figures(material: Material, folder: Path) -> list[Illustration]:
    """Draw every figure that there are rows for, and say under each how to read it."""
    illustrations = []
    with styled():
        for name, caption, draw in _plan(material):
            png, _ = save(draw(), folder, name, material.config.dpi)
            illustrations.append(Illustration(name, caption, png))
    return illustrations


def _remove_others(folder: Path, kept: Collection[Path]) -> None:
    """Remove what an earlier report wrote and this one did not."""
    for path in folder.glob("*"):
        if path.suffix in WRITTEN and path not in kept:
            path.unlink()


def _plan(material: Material) -> Iterator[tuple[str, str, Callable[[], Figure]]]:
    results, published, config = material.results, material.published, material.config
    rows, summary, pairs = results.evaluate, material.summary, material.pairs
    if rows:
        yield (
            "against_the_paper",
            "This run beside the paper's Table II, in the paper's metric.",
            lambda: benchmark.against_the_paper(summary, published),
        )
        yield (
            "success_against_tolerance",
            "Share of test poses within a tolerance of x mm and x deg (Euclidean, geodesic, joint "
            "limits kept). The line at 1 is the strict success of the tables.",
            lambda: benchmark.success_against_tolerance(rows, config),
        )
        yield (
            "error_against_time",
            "Mean error in the paper's metric against time per pose; numbers at the points are "
            "batch sizes. Towards the lower left is better. Stars: the paper.",
            lambda: benchmark.error_against_time(summary, published),
        )
        yield (
            "error_distributions",
            "Median (marker), middle half (thick) and 1st to 99th percentile (thin) of the errors.",
            lambda: benchmark.error_distributions(rows, config),
        )
        if any(solver == MAPPED for _, solver in rows):
            yield (
                "workspace_map",
                "Median position error of CycleIK over the workspace: distance from the base's "
                "vertical axis, and height.",
                lambda: benchmark.workspace_map(rows, MAPPED, config),
            )
    if len(pairs):
        yield (
            "win_matrix",
            "Share of poses [%] on which the solver of the row is nearer to the target than that "
            "of the column.",
            lambda: benchmark.win_matrix(pairs),
        )
    if any(len(curve) for _, curve in results.train.values()):
        yield (
            "training_curves",
            "Mean Euclidean and geodesic errors while training; batches smoothed by a moving "
            "median.",
            lambda: experiment.training_curves(results.train),
        )
    if results.plan:
        yield (
            "planner_times",
            "Time and largest tip error of every plan; the dashed line is the paper's 70 ms.",
            lambda: experiment.planner_times(results.plan, published),
        )
    if results.grasp:
        yield (
            "grasp_outcomes",
            "Figure 5 of the paper: outcomes of grasp trials, with Wilson intervals. The paper's "
            "trials ran on hardware, with detector and language model.",
            lambda: experiment.grasp_outcomes(results.grasp, published, config),
        )
