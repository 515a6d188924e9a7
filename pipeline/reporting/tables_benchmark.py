"""The paper's Tables II and III, solvers against each other, with this run beside the paper."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

from pipeline.evaluation.config import solver_of_rows
from pipeline.reporting.naming import (
    NEURAL,
    ordered_robots,
    ordered_solvers,
    robot_title,
    solver_title,
)
from pipeline.reporting.published import Published
from pipeline.reporting.table import Cell, Column, Table

# Metric of the paper, our column of the summary, factor to the paper's unit, heading.
METRICS = {
    "position_error_mean": ("paper_position_error_mm_mean", 1.0, "pos. [mm]"),
    "position_error_sd": ("paper_position_error_mm_sd", 1.0, "σ pos. [mm]"),
    "rotation_error_mean": ("paper_rotation_error_deg_mean", 1.0, "rot. [deg]"),
    "rotation_error_sd": ("paper_rotation_error_deg_sd", 1.0, "σ rot. [deg]"),
    "success_rate": ("success_paper", 100.0, "success [%]"),
    "time_per_pose": ("time_per_pose_mean_us", 1e-3, "time [ms]"),
}
# Our own metric: name, column of the summary, column of the table.
OWN = "our metric"
OURS = (
    ("position_error_mm_mean", Column("euclidean_mm", "Euclidean [mm]", OWN, 3)),
    ("rotation_error_deg_mean", Column("geodesic_deg", "geodesic [deg]", OWN, 3)),
    ("success_strict", Column("strict", "1 mm, 1 deg [%]", OWN, percent=2)),
    ("success_strict_low", Column("strict_low", "from", OWN, percent=2)),
    ("success_strict_high", Column("strict_high", "to", OWN, percent=2)),
)
BATCH_OF_TABLE_III = 100


def numerical_comparison(summary: pd.DataFrame, published: Published) -> Table:
    """Table II: precision, success and time per pose in the paper's metric, and in ours.

    Args:
        summary: From `summarise`; may be empty.
        published: The paper's numbers.

    Returns:
        One row per robot and solver; a solver that only the paper has keeps a row.
    """
    table = Table(
        name="table2_numerical_comparison",
        title="Table II: CycleIK and numerical solvers",
        caption="Errors averaged over the axes and success below 10 mm and 20 deg on those "
        "averages, as in the paper; time is the mean per pose at batch size 1. Each number of "
        "this run (ours) stands beside the paper's, with the difference Δ (ours − paper). Our "
        "metric: mean Euclidean distance and geodesic angle, and the share of poses below 1 mm and "
        "1 deg of them with joint limits kept, with its Wilson interval.",
        columns=[Column("robot", "Robot"), Column("solver", "Solver")],
    )
    for metric, (_, _, title) in METRICS.items():
        table.columns += _triple(metric, title)
    table.columns += [column for _, column in OURS]
    table.columns += [Column("poses", "poses"), Column("cores", "cores")]
    for robot in ordered_robots(_robots(summary)):
        for solver in _solvers(summary, published, "numerical_comparison", robot):
            main = _line(summary, robot, solver)
            single = _line(summary, robot, solver, batch_size=1)
            cells = _own_cells(main)
            for metric, (column, factor, _) in METRICS.items():
                line = single if metric == "time_per_pose" else main
                ours = None if line is None else float(line[column]) * factor
                paper = _published(published, "numerical_comparison", robot, solver, metric)
                cells |= _filled(metric, ours, paper)
            table.add(robot=robot_title(robot), solver=solver_title(solver), **cells)
    _note_poses(table, summary)
    table.notes.append(
        "The paper's numerical solvers ran with 1 ms per pose in MoveIt; budgets here are those of "
        "the configuration. Its network ran on a graphics processor. A solver that is unpinned may "
        "use every core; TRAC-IK races two threads, which share one core otherwise."
    )
    return table


def neural_comparison(summary: pd.DataFrame, published: Published) -> Table:
    """Table III: neural solvers, with time for a batch of 100."""
    table = Table(
        name="table3_neural_comparison",
        title="Table III: neural solvers",
        caption="Mean errors in the paper's metric (averages over the axes) beside the paper's "
        "numbers, and in our metric as Euclidean distance and geodesic angle, which is what IKFlow "
        "and EEM report. Time is the mean for a batch of 100 poses.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("source", "Source"),
            *_triple("position_error_mean", "pos. [mm]"),
            *_triple("rotation_error_mean", "rot. [deg]"),
            *_triple("time_per_batch_of_100", "time of 100 [ms]"),
            *(column for _, column in OURS),
            Column("poses", "poses"),
        ],
    )
    for robot in published.robots("neural_comparison"):
        for solver in _neural(summary, published, robot):
            main = _line(summary, robot, solver)
            hundred = _line(summary, robot, solver, BATCH_OF_TABLE_III)
            ours = {
                "position_error_mean": _value(main, "paper_position_error_mm_mean"),
                "rotation_error_mean": _value(main, "paper_rotation_error_deg_mean"),
                "time_per_batch_of_100": _value(hundred, "time_per_batch_mean_ms"),
            }
            cells = _own_cells(main)
            cells.pop("cores")
            for metric, value in ours.items():
                paper = published.number("neural_comparison", robot, solver, metric)
                cells |= _filled(metric, value, paper)
            source = "published" if main is None else "this run"
            cells |= {"solver": solver_title(solver), "source": source}
            table.add(robot=robot_title(robot), **cells)
    _note_poses(table, summary[summary.solver.isin(NEURAL)] if len(summary) else summary)
    table.notes.append(
        "IKFlow and EEM are published numbers only: Euclidean and geodesic, so the paper's table "
        "mixes metrics. IKFlow's Valkyrie is the left arm with the waist, its Panda ends at "
        "panda_hand. Our flow answers with the best of its draws, where IKFlow's error is a mean "
        "over draws: that of ours is in the table of many solutions of one pose."
    )
    return table


def _triple(metric: str, title: str) -> list[Column]:
    decimals = 2 if metric == "success_rate" else None
    return [
        Column(metric, "ours", title, 3, decimals=decimals),
        Column(f"{metric}_paper", "paper", title),
        Column(f"{metric}_difference", "Δ", title, 2, signed=True, decimals=decimals),
    ]


def _filled(metric: str, ours: float | None, paper: float | None) -> dict[str, Cell]:
    difference = None if ours is None or paper is None else ours - paper
    return {metric: ours, f"{metric}_paper": paper, f"{metric}_difference": difference}


def _own_cells(line: pd.Series | None) -> dict[str, Cell]:
    cells: dict[str, Cell] = {column.name: _value(line, source) for source, column in OURS}
    cells["poses"] = None if line is None else int(line.poses)
    cells["cores"] = None if line is None else int(line.threads)
    return cells


def _published(
    published: Published, table: str, robot: str, solver: str, metric: str
) -> float | None:
    """The paper's number for the solver behind the rows: it has one TRAC-IK, pinned or not."""
    return published.number(table, robot, solver_of_rows(solver), metric)


def _line(
    summary: pd.DataFrame, robot: str, solver: str, batch_size: int | None = None
) -> pd.Series | None:
    if summary.empty:
        return None
    wanted = (summary.robot == robot) & (summary.solver == solver)
    wanted &= summary.main if batch_size is None else summary.batch_size == batch_size
    return summary[wanted].iloc[0] if wanted.any() else None


def _value(line: pd.Series | None, column: str) -> float | None:
    return None if line is None else float(line[column])


def _robots(summary: pd.DataFrame) -> list[str]:
    return [] if summary.empty else list(summary.robot.unique())


def _solvers(summary: pd.DataFrame, published: Published, table: str, robot: str) -> list[str]:
    return ordered_solvers([*_ours(summary, robot), *published.methods(table, robot)])


def _neural(summary: pd.DataFrame, published: Published, robot: str) -> list[str]:
    ours = [solver for solver in _ours(summary, robot) if solver in NEURAL]
    return ordered_solvers([*ours, *published.methods("neural_comparison", robot)])


def _ours(summary: pd.DataFrame, robot: str) -> Iterable[str]:
    return [] if summary.empty else summary[summary.robot == robot].solver.unique()


def _note_poses(table: Table, summary: pd.DataFrame) -> None:
    if not summary.empty:
        poses = sorted({int(n) for n in summary[summary.main].poses})
        counts = " to ".join(f"{n:,}" for n in dict.fromkeys((poses[0], poses[-1])))
        table.notes.append(f"This run: {counts} test poses a robot; the paper: 200,000.")
