"""Our own tables of the solver benchmark: precision, time, and solvers in pairs."""

from __future__ import annotations

import pandas as pd

from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import ordered_robots, ordered_solvers, robot_title, solver_title
from pipeline.reporting.table import Cell, Column, Table


def precision(summary: pd.DataFrame, config: ReportConfig) -> Table:
    """Our own table: Euclidean and geodesic errors, success at two tolerances, claims."""
    strict, loose = config.success.strict, config.success.loose
    tight, wide = (f"{t.position_mm:g} mm, {t.rotation_deg:g} deg" for t in (strict, loose))
    percent = f"{config.confidence * 100:g} %"
    table = Table(
        name="precision",
        title="Precision, Euclidean and geodesic",
        caption=f"Recomputed from the joints. Strict is below {tight}, loose below {wide}, both "
        f"with joint limits kept. Intervals are {percent}: Wilson for rates, bootstrap for means, "
        f"over poses and, where there are several trainings, apart from that over their seeds.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("poses", "poses"),
            Column("position_mean_mm", "mean", "position error [mm]", 3),
            Column("position_low_mm", "from", "position error [mm]", 3),
            Column("position_high_mm", "to", "position error [mm]", 3),
            *_over_seeds(summary),
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
            **_seed_cells(line, table),
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


def _over_seeds(summary: pd.DataFrame) -> list[Column]:
    """Columns for the interval over training seeds; none where there is one training each."""
    if summary.empty or not (summary.seeds > 1).any():
        return []
    group = "position error [mm]"
    return [
        Column("seeds", "seeds", group),
        Column("position_seeds_low_mm", "seeds, from", group, 3),
        Column("position_seeds_high_mm", "seeds, to", group, 3),
    ]


def _seed_cells(line: pd.Series, table: Table) -> dict[str, Cell]:
    cells: dict[str, Cell] = {
        "seeds": int(line.seeds),
        "position_seeds_low_mm": line.position_error_mm_mean_seeds_low,
        "position_seeds_high_mm": line.position_error_mm_mean_seeds_high,
    }
    named = {column.name for column in table.columns}
    return {name: cell for name, cell in cells.items() if name in named}


def timing(summary: pd.DataFrame) -> Table:
    """Time by batch size, by the paper's protocol and by ours side by side."""
    paper, ours = "as the paper [ms]", "time per pose [µs]"
    table = Table(
        name="time",
        title="Time",
        caption="Wall time of a call, shared out over its poses, after a warm-up, on as many cores "
        "as told. The paper gives the mean per sample at batch size 1 and the mean per batch. "
        "Beside it mean, median and 99th percentile over the calls (of few calls the percentile is "
        "the largest); the solver's own clock leaves out what the call itself costs.",
        columns=[
            Column("robot", "Robot"),
            Column("solver", "Solver"),
            Column("batch_size", "batch size"),
            Column("calls", "calls"),
            Column("sample_ms", "per sample", paper, 3),
            Column("batch_ms", "per batch", paper, 3),
            Column("mean_us", "mean", ours, 3),
            Column("median_us", "median", ours, 3),
            Column("p99_us", "p99", ours, 3),
            Column("solver_median_us", "own clock, median", ours, 3),
            Column("iterations", "iterations, mean", "", 3),
            Column("cores", "cores"),
            Column("pinned", "pinned"),
        ],
    )
    for _, line in _sorted(summary).iterrows():
        table.add(
            robot=robot_title(line.robot),
            solver=solver_title(line.solver),
            batch_size=int(line.batch_size),
            calls=int(line.calls),
            sample_ms=line.time_per_pose_mean_us / 1e3 if line.batch_size == 1 else None,
            batch_ms=line.time_per_batch_mean_ms,
            mean_us=line.time_per_pose_mean_us,
            median_us=line.time_per_pose_median_us,
            p99_us=line.time_per_pose_p99_us,
            solver_median_us=line.solver_time_median_us,
            iterations=line.iterations_mean,
            cores=int(line.threads),
            pinned="yes" if line.pinned else "no",
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


def _p_value(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
