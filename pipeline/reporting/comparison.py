"""Two solvers on the same poses: who is better, by how much, and how sure that is."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pandas as pd

from pipeline.evaluation.statistics import holm, mcnemar, wilcoxon
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import ordered_solvers
from pipeline.reporting.summary import apply_not_found, main_batch, successes


def compare_solvers(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """Compare every pair of solvers of one robot on the poses that both answered.

    Args:
        rows: Raw rows of one robot.
        config: Not-found policy and success.

    Returns:
        One line a pair: difference of the strict success rate with McNemar's p, median difference
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


def _by_pose(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """Strict success and position error [mm] of one solver at its main batch size, by pose.

    Of several seeds the first.
    """
    main = rows[rows.batch_size == main_batch(rows)]
    counted = apply_not_found(main, config.not_found)
    reached = successes(counted, "geodesic", config.success.strict)
    values = pd.DataFrame({"reached": reached, "error": counted.position_error_mm.to_numpy()})
    # The target is part of the key: pose 7 of another test set is another pose.
    values.index = pd.MultiIndex.from_frame(main[["pose", "target_x_m"]].reset_index(drop=True))
    return values[~values.index.duplicated()]


def _adjusted(lines: pd.DataFrame) -> pd.DataFrame:
    for name in ("success_p", "error_p") if len(lines) else ():
        adjusted = holm({str(i): float(p) for i, p in lines[name].items()})
        lines[f"{name}_holm"] = [adjusted[str(i)] for i in lines.index]
    return lines
