"""metrics.json: the few numbers that `dvc metrics diff` compares between two runs."""

from __future__ import annotations

import math
from typing import Any

import pandas as pd

from pipeline.presentation.naming import outcome_key
from pipeline.reporting.results import Results
from pipeline.reporting.topics.planner import one_row_a_plan

MAIN = (
    "position_error_mm_mean",
    "rotation_error_deg_mean",
    "paper_position_error_mm_mean",
    "paper_rotation_error_deg_mean",
    "success_strict",
    "success_loose",
    "success_paper",
)
DIGITS = 6


def headline_metrics(results: Results, summary: pd.DataFrame) -> dict[str, Any]:
    """Collect the numbers of a run, by stage, robot and solver; what is missing is left out."""
    metrics: dict[str, Any] = {}
    for _, line in summary.iterrows():
        place = metrics.setdefault("evaluate", {}).setdefault(line.robot, {})
        numbers = place.setdefault(line.solver, {})
        numbers[f"time_per_pose_median_us_batch_{line.batch_size}"] = line.time_per_pose_median_us
        if line.main:
            numbers |= {name: line[name] for name in MAIN}
            numbers["claimed_and_wrong"] = line.claimed_and_wrong
    for (robot, model), (card, _) in results.train.items():
        place = metrics.setdefault("train", {}).setdefault(robot, {})
        place[model] = dict(card.get("validation") or {})
    for robot, rows in results.plan.items():
        for solver, plans in one_row_a_plan(rows).groupby("solver"):
            place = metrics.setdefault("plan", {}).setdefault(robot, {})
            place[str(solver)] = {
                f"{name}_median": plans[name].median()
                for name in ("plan_time_ms", "tip_error_mm")
                if name in plans
            }
    for robot, trials in results.grasp.items():
        success = (trials["class"].map(outcome_key) == "success").mean()
        metrics.setdefault("grasp", {})[robot] = {"success": success, "trials": len(trials)}
    return _plain(metrics)


def _plain(content: Any) -> Any:
    """Numbers that JSON has, rounded so that noise in the last digits is no change."""
    if isinstance(content, dict):
        return {key: _plain(value) for key, value in content.items()}
    if hasattr(content, "item"):
        content = content.item()
    if isinstance(content, float):
        if not math.isfinite(content):
            return None
        return float(f"{content:.{DIGITS}g}")
    return content
