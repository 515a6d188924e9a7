"""What tables and figures are made of: rows on disk, their summary, solvers in pairs."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from pipeline.reporting.comparison import compare_solvers
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.losses import compare_losses, losses_table
from pipeline.reporting.naming import ordered_robots
from pipeline.reporting.published import Published
from pipeline.reporting.results import Results, read_results
from pipeline.reporting.seeding import adjusted, same_budget, seed_effects
from pipeline.reporting.summary import summarise
from pipeline.reporting.table import Table
from pipeline.reporting.tables_agent_grasps import agent_failures, agent_grasping, agent_sight
from pipeline.reporting.tables_benchmark import neural_comparison, numerical_comparison
from pipeline.reporting.tables_detector import detectors
from pipeline.reporting.tables_experiments import constraints, solutions
from pipeline.reporting.tables_grasps import grasp_objects, grasp_studies
from pipeline.reporting.tables_planner import planner, planner_routes
from pipeline.reporting.tables_seeds import neural_seeds
from pipeline.reporting.tables_solvers import comparisons, precision, timing
from pipeline.reporting.tables_training import datasets, hyperparameters, training
from pipeline.reporting.tables_trials import grasping
from pipeline.reporting.tables_tuning import studies, tuned_against_table_one


@dataclass(frozen=True)
class ReportData:
    """What tables and figures are made of.

    Attributes:
        results: Everything on disk.
        published: The paper's numbers.
        summary: One line a robot, solver and batch size.
        pairs: Two solvers on the same poses, one line a pair.
        effects: One solver from home and from a neural seed, one line a batch size.
        config: Policies, confidence, looks.
    """

    results: Results
    published: Published
    summary: pd.DataFrame
    pairs: pd.DataFrame
    effects: pd.DataFrame
    config: ReportConfig


def load(
    results_dir: Path, published: Published, config: ReportConfig, profile: str = ""
) -> ReportData:
    """Read the results and summarise their raw rows, one file at a time."""
    results = read_results(results_dir, profile)
    lines = [summarise(rows, config) for rows in results.evaluate.values()]
    summary = pd.concat(lines, ignore_index=True) if lines else pd.DataFrame()
    pairs = []
    for robot in ordered_robots(results.robots):
        mine = [results.evaluate[robot, solver] for solver in results.solvers(robot)]
        if len(mine) > 1:
            pairs.append(compare_solvers(pd.concat(mine, ignore_index=True), config))
    return ReportData(
        results, published, summary, _joined(pairs), _effects(results, config), config
    )


def make_tables(data: ReportData) -> list[Table]:
    """Make every table that has rows, in the order of the report."""
    results, published, summary = data.results, data.published, data.summary
    made = [
        numerical_comparison(summary, published),
        neural_comparison(summary, published),
        precision(summary, data.config),
        timing(summary),
        neural_seeds(data.effects, data.config),
        comparisons(data.pairs, data.config),
        hyperparameters(results, published),
        studies(results),
        tuned_against_table_one(results),
        datasets(results),
        training(results),
        losses_table(compare_losses(results.swept)),
        constraints(results),
        solutions(results),
        planner(results, published),
        planner_routes(results),
        grasping(results, published, data.config),
        grasp_objects(results, data.config),
        grasp_studies(results, data.config),
        agent_grasping(results, published, data.config),
        agent_sight(results),
        agent_failures(results),
        detectors(results),
    ]
    return [table for table in made if table.rows]


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
