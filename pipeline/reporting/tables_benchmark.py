"""Tables of the solver benchmark: the paper's Tables II and III with ours beside, and our own."""

from __future__ import annotations

import pandas as pd

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import ordered_robots, ordered_solvers, robot_title, solver_title
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
BATCH_OF_TABLE_III = 100


def numerical_comparison(summary: pd.DataFrame, published: Published) -> Table:
    """Table II: precision, success and time per pose in the paper's metric.

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
        "this run (ours) stands beside the paper's, with the difference Δ (ours − paper).",
        columns=[Column("robot", "Robot"), Column("solver", "Solver")],
    )
    for metric, (_, _, title) in METRICS.items():
        table.columns += _triple(metric, title)
    for robot in ordered_robots(_robots(summary)):
        for solver in _solvers(summary, published, "numerical_comparison", robot):
            main = _line(summary, robot, solver)
            single = _line(summary, robot, solver, batch_size=1)
            cells: dict[str, Cell] = {}
            for metric, (column, factor, _) in METRICS.items():
                line = single if metric == "time_per_pose" else main
                ours = None if line is None else float(line[column]) * factor
                paper = published.number("numerical_comparison", robot, solver, metric)
                cells |= _filled(metric, ours, paper)
            table.add(robot=robot_title(robot), solver=solver_title(solver), **cells)
    _note_poses(table, summary)
    table.notes.append(
        "The paper's numerical solvers ran with 1 ms per pose in MoveIt; budgets here are those of "
        "the configuration. Its network ran on a graphics processor."
    )
    return table


def neural_comparison(summary: pd.DataFrame, published: Published) -> Table:
    """Table III: neural solvers, with time for a batch of 100."""
    table = Table(
        name="table3_neural_comparison",
        title="Table III: neural solvers",
        caption="Mean errors in the paper's metric (averages over the axes) beside the paper's "
        "numbers, and as Euclidean distance and geodesic angle, which is what IKFlow and EEM "
        "report. Time is the mean for a batch of 100 poses.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            *_triple("position_error_mean", "pos. [mm]"),
            *_triple("rotation_error_mean", "rot. [deg]"),
            Column("euclidean_mm", "Euclidean [mm]", "this run", 3),
            Column("geodesic_deg", "geodesic [deg]", "this run", 3),
            *_triple("time_per_batch_of_100", "time of 100 [ms]"),
        ],
    )
    for robot in published.robots("neural_comparison"):
        for method in published.methods("neural_comparison", robot):
            main = _line(summary, robot, method)
            hundred = _line(summary, robot, method, BATCH_OF_TABLE_III)
            ours = {
                "position_error_mean": _value(main, "paper_position_error_mm_mean"),
                "rotation_error_mean": _value(main, "paper_rotation_error_deg_mean"),
                "time_per_batch_of_100": _value(hundred, "time_per_batch_mean_ms"),
            }
            cells: dict[str, Cell] = {
                "euclidean_mm": _value(main, "position_error_mm_mean"),
                "geodesic_deg": _value(main, "rotation_error_deg_mean"),
            }
            for metric, value in ours.items():
                paper = published.number("neural_comparison", robot, method, metric)
                cells |= _filled(metric, value, paper)
            table.add(robot=robot_title(robot), solver=solver_title(method), **cells)
    table.notes.append(
        "IKFlow and EEM are published numbers only: Euclidean and geodesic, so the paper's table "
        "mixes metrics. IKFlow's Valkyrie is the left arm with the waist, its Panda ends at "
        "panda_hand."
    )
    return table


def precision(summary: pd.DataFrame, config: ReportConfig) -> Table:
    """Our own table: Euclidean and geodesic errors, success at two tolerances, claims."""
    strict, loose = config.success.strict, config.success.loose
    tight, wide = (f"{t.position_mm:g} mm, {t.rotation_deg:g} deg" for t in (strict, loose))
    percent = f"{config.confidence * 100:g} %"
    table = Table(
        name="precision",
        title="Precision, Euclidean and geodesic",
        caption=f"Recomputed from the joints. Strict is below {tight}, loose below {wide}, both "
        f"with joint limits kept. Intervals are {percent}: Wilson for rates, bootstrap over poses "
        f"for means.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("poses", "poses"),
            Column("position_mean_mm", "mean", "position error [mm]", 3),
            Column("position_low_mm", "from", "position error [mm]", 3),
            Column("position_high_mm", "to", "position error [mm]", 3),
            Column("position_median_mm", "median", "position error [mm]", 3),
            Column("position_p90_mm", "p90", "position error [mm]", 3),
            Column("position_p99_mm", "p99", "position error [mm]", 3),
            Column("rotation_mean_deg", "mean", "rotation error [deg]", 3),
            Column("rotation_median_deg", "median", "rotation error [deg]", 3),
            Column("rotation_p99_deg", "p99", "rotation error [deg]", 3),
            Column("strict", "rate", "strict [%]", percent=2),
            Column("strict_low", "from", "strict [%]", percent=2),
            Column("strict_high", "to", "strict [%]", percent=2),
            Column("loose", "loose [%]", percent=2),
            Column("found", "found [%]", "claims", percent=1),
            Column("claimed_and_wrong", "wrong", "claims"),
            Column("outside_limits", "off limits", "claims"),
        ],
    )
    for _, line in _main(summary).iterrows():
        table.add(
            robot=robot_title(line.robot),
            solver=solver_title(line.solver),
            poses=int(line.poses),
            position_mean_mm=line.position_error_mm_mean,
            position_low_mm=line.position_error_mm_mean_low,
            position_high_mm=line.position_error_mm_mean_high,
            position_median_mm=line.position_error_mm_median,
            position_p90_mm=line.position_error_mm_p90,
            position_p99_mm=line.position_error_mm_p99,
            rotation_mean_deg=line.rotation_error_deg_mean,
            rotation_median_deg=line.rotation_error_deg_median,
            rotation_p99_deg=line.rotation_error_deg_p99,
            strict=line.success_strict,
            strict_low=line.success_strict_low,
            strict_high=line.success_strict_high,
            loose=line.success_loose,
            found=line.found,
            claimed_and_wrong=int(line.claimed_and_wrong),
            outside_limits=int(line.outside_limits),
        )
    return table


def timing(summary: pd.DataFrame) -> Table:
    """Time by batch size: the paper's protocol (mean) beside median and 99th percentile."""
    group = "time per pose [µs]"
    table = Table(
        name="time",
        title="Time",
        caption="Wall time of a call shared out over its poses, pinned, after a warm-up; the "
        "solver's own clock leaves out what the call itself costs.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("batch_size", "batch size"),
            Column("poses", "poses"),
            Column("mean_us", "mean", group, 3),
            Column("median_us", "median", group, 3),
            Column("p99_us", "p99", group, 3),
            Column("solver_median_us", "own clock, median", group, 3),
            Column("batch_ms", "batch, mean [ms]", "", 3),
            Column("iterations", "iterations, mean", "", 3),
            Column("threads", "threads"),
        ],
    )
    for _, line in _sorted(summary).iterrows():
        table.add(
            robot=robot_title(line.robot),
            solver=solver_title(line.solver),
            batch_size=int(line.batch_size),
            poses=int(line.poses),
            mean_us=line.time_per_pose_mean_us,
            median_us=line.time_per_pose_median_us,
            p99_us=line.time_per_pose_p99_us,
            solver_median_us=line.solver_time_median_us,
            batch_ms=line.time_per_batch_mean_ms,
            iterations=line.iterations_mean,
            threads=int(line.threads),
        )
    return table


def comparisons(pairs: pd.DataFrame, config: ReportConfig) -> Table:
    """Solvers against each other on the same poses; effect first, then how sure it is."""
    strict = config.success.strict
    table = Table(
        name="paired_comparison",
        title="Solvers against each other on the same poses",
        caption=f"Difference of the rates within {strict.position_mm:g} mm and "
        f"{strict.rotation_deg:g} deg (McNemar) and median difference of the position errors "
        f"(Wilcoxon), first − second; p adjusted by Holm over the pairs of a robot.",
        columns=[
            Column("robot", "Robot"),
            Column("first", "first"),
            Column("second", "second"),
            Column("poses", "poses"),
            Column("success_difference", "difference [points]", "success", percent=2, signed=True),
            Column("success_p", "p", "success"),
            Column("error_difference_mm", "median difference [mm]", "position error", 3, True),
            Column("error_p", "p", "position error"),
            Column("first_nearer", "first is nearer [%]", "position error", percent=1),
        ],
    )
    for _, pair in pairs.iterrows():
        table.add(
            robot=robot_title(pair.robot),
            first=solver_title(pair["first"]),
            second=solver_title(pair["second"]),
            poses=int(pair.poses),
            success_difference=pair.success_difference,
            success_p=_p_value(pair.success_p_holm),
            error_difference_mm=pair.error_median_difference_mm,
            error_p=_p_value(pair.error_p_holm),
            first_nearer=pair.first_nearer,
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
    ours = list(summary[summary.robot == robot].solver.unique())
    return ordered_solvers([*ours, *published.methods(table, robot)])


def _main(summary: pd.DataFrame) -> pd.DataFrame:
    return summary if summary.empty else _sorted(summary[summary.main])


def _sorted(summary: pd.DataFrame) -> pd.DataFrame:
    """In the order of robots, solvers and batch sizes that all tables share."""
    if summary.empty:
        return summary
    robots, solvers = ordered_robots(summary.robot), ordered_solvers(summary.solver)
    order = pd.DataFrame(
        {
            "robot": summary.robot.map(robots.index),
            "solver": summary.solver.map(solvers.index),
            "batch_size": summary.batch_size,
        }
    )
    return summary.loc[order.sort_values(["robot", "solver", "batch_size"]).index]


def _note_poses(table: Table, summary: pd.DataFrame) -> None:
    if not summary.empty:
        poses = sorted({int(n) for n in summary[summary.main].poses})
        counts = " to ".join(f"{n:,}" for n in dict.fromkeys((poses[0], poses[-1])))
        table.notes.append(f"This run: {counts} test poses a robot; the paper: 200,000.")


def _p_value(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
