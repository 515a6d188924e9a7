"""Two solvers on the same poses: who is better, by how much, and how sure that is."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.evaluation.statistics import holm, mcnemar, wilcoxon
from pipeline.presentation.columns import ROBOT, count, number, p_value, share, text, under
from pipeline.presentation.naming import ordered_robots, ordered_solvers, solver_title
from pipeline.presentation.style import INK, robot_panels
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig, tolerance_title
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.summary import counted, successes

MEDIAN = "median difference [mm]"
COLUMNS = (
    ROBOT,
    text("first", "first", convert=solver_title),
    text("second", "second", convert=solver_title),
    count("poses", "poses"),
    *under(
        "success",
        share("success_difference", "difference [points]", decimals=2, signed=True),
        p_value("success_p", "success_p_holm"),
    ),
    *under(
        "position error",
        number("error_difference_mm", MEDIAN, "error_median_difference_mm", signed=True),
        p_value("error_p", "error_p_holm"),
        share("first_nearer", "first is nearer [%]"),
    ),
)


def compare_solvers(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """Compare every pair of solvers of one robot on the poses that both answered.

    Args:
        rows: Raw rows of one robot.
        config: Not-found policy and success.

    Returns:
        One line a pair: difference of the success rate with McNemar's p, median difference
        of the position error [mm] with Wilcoxon's p, both adjusted by Holm over the robot's pairs,
        and the shares of poses on which either is nearer.
    """
    solvers = {
        name: _by_pose(rows[rows.solver == name], config) for name in ordered_solvers(rows.solver)
    }
    lines = []
    for first, second in combinations(solvers, 2):
        a, b = solvers[first].align(solvers[second], join="inner", axis=0)
        if a.empty:
            continue
        rate = mcnemar(a.reached, b.reached)
        error = wilcoxon(a.error, b.error)
        lines.append(
            {
                "robot": rows.robot.iloc[0],
                "first": first,
                "second": second,
                "poses": len(a),
                "success_difference": rate.effect,
                "success_p": rate.p_value,
                "error_median_difference_mm": error.effect,
                "error_p": error.p_value,
                "first_nearer": float(np.mean(a.error.to_numpy() < b.error.to_numpy())),
                "second_nearer": float(np.mean(b.error.to_numpy() < a.error.to_numpy())),
            }
        )
    return _adjusted(pd.DataFrame(lines))


def comparisons(pairs: pd.DataFrame, config: ReportConfig) -> Table:
    """Solvers against each other on the same poses; effect first, then how sure it is."""
    return Table.of(
        pairs,
        COLUMNS,
        name="paired_comparison",
        title="Solvers against each other on the same poses",
        caption=f"Difference of the success rates at {tolerance_title(config.success.strict)} "
        f"(McNemar) and median difference of the position errors (Wilcoxon), first − "
        "second; p adjusted by Holm over the pairs of a robot.",
    )


def win_matrix(pairs: pd.DataFrame) -> Figure:
    """Share of poses on which the solver of the row is nearer than that of the column."""
    robots = ordered_robots(pairs.robot)
    most = max(len(_compared(pairs[pairs.robot == robot])) for robot in robots)
    size = (max(0.5 * most + 1.5, 3.0), 0.4 * most + 1.2)
    figure, axes = robot_panels(robots, *size, columns=2 if most > 6 else 3)
    for robot, axis in axes.items():
        mine = pairs[pairs.robot == robot]
        solvers = _compared(mine)
        share = np.full((len(solvers), len(solvers)), np.nan)
        for _, pair in mine.iterrows():
            i, j = solvers.index(pair["first"]), solvers.index(pair["second"])
            share[i, j], share[j, i] = pair.first_nearer, pair.second_nearer
        axis.imshow(share, cmap="Greys", vmin=0, vmax=1.25)
        for i, j in zip(*np.nonzero(~np.isnan(share)), strict=True):
            colour = "white" if share[i, j] > 0.62 else INK
            axis.text(j, i, f"{share[i, j] * 100:.0f}", ha="center", va="center", color=colour)
        names = [solver_title(name) for name in solvers]
        axis.set_xticks(range(len(names)), names, rotation=35, ha="right")
        axis.set_yticks(range(len(names)), names)
        axis.grid(visible=False)
    return figure


def _by_pose(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """Strict success and position error [mm] of one solver at its main batch size, by pose.

    Of several seeds the first.
    """
    main = counted(rows, config)
    reached = successes(main, "geodesic", config.success.strict)
    values = pd.DataFrame({"reached": reached, "error": main.position_error_mm.to_numpy()})
    # The target is part of the key: pose 7 of another test set is another pose.
    values.index = pd.MultiIndex.from_frame(main[["pose", "target_x_m"]].reset_index(drop=True))
    return values[~values.index.duplicated()]


def _adjusted(lines: pd.DataFrame) -> pd.DataFrame:
    for name in ("success_p", "error_p") if len(lines) else ():
        adjusted = holm({str(i): float(p) for i, p in lines[name].items()})
        lines[f"{name}_holm"] = [adjusted[str(i)] for i in lines.index]
    return lines


def _compared(pairs: pd.DataFrame) -> list[str]:
    return ordered_solvers([*pairs["first"], *pairs["second"]])


TOPIC = Topic(
    tables=(lambda data: comparisons(data.pairs, data.config),),
    plots=(
        Plot(
            "win_matrix",
            "Share of poses [%] on which the solver of the row is nearer to the target than that "
            "of the column.",
            lambda data: len(data.pairs),
            lambda data: win_matrix(data.pairs),
        ),
    ),
)
