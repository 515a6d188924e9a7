"""From a file that was sent to its line: every answer is judged again, errors are not believed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.data.files import sha256
from pipeline.evaluation.statistics import shifted_geometric_mean
from pipeline.leaderboard.schema import FIELDS, within_name
from pipeline.leaderboard.submission import ANSWERED, Submission, times_us
from pipeline.reporting.suite_measures import RATES, generator_of, good_poses, good_trials
from pipeline.suites.config import UNREACHABLE
from pipeline.suites.judging import judge_answers
from pipeline.suites.part import answered_part

if TYPE_CHECKING:
    from pipeline.evaluation.config import EvaluateConfig
    from pipeline.reporting.config import LeaderboardConfig, ReportConfig
    from pipeline.suites.generators import Suite
    from robots import Robot

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SOLVED = "solved"  # criterion of suites whose rate has no name of its own
ERRORS = {"position": ("position_error_mm", "mm"), "rotation": ("rotation_error_deg", "deg")}


def line_of(
    sent: Submission, suite: Suite, robot: Robot, evaluate: EvaluateConfig, report: ReportConfig
) -> tuple[dict[str, Any], list[str]]:
    """Judge what was sent and sum it up.

    Args:
        sent: The file.
        suite: That it answers.
        robot: The robot.
        evaluate: Tolerance of a claim, slack of a limit.
        report: What solved means, and what is said of times.

    Returns:
        Values by the columns of `FIELDS` and of the success profile; what is wrong with answers.

    Raises:
        SuiteError: It answers another suite, or not in the way that `judge` reads.
    """
    suite = answered_part(suite, sent.answers)
    name, seed = str(sent.facts["solver"]), int(sent.facts["seed"])
    judged = judge_answers(sent.answers, sent.path, name, suite, robot, evaluate, seed)
    rows = _as_answered(judged.rows, sent.answers)
    times = times_us(sent.answers, len(rows), sent.path)
    good = good_poses(rows, report)
    tolerance = report.success.strict
    values = {
        **{key: value for key, value in sent.facts.items() if key in FIELDS},
        "robot_source": robot_source(robot),
        "suite_version": suite.version,
        "suite_checksum": suite.checksum,
        "batch_size": sent.facts.get("batch_size", 1),
        "timed_by": sent.timed_by,
        "answers_sha256": sha256(sent.path),
        "position_mm": tolerance.position_mm,
        "rotation_deg": tolerance.rotation_deg,
        **_counts(rows, good, report),
        **_errors(rows),
        "self_colliding": _self_colliding(rows, good),
        **_times(times, good, report.leaderboard),
    }
    order = [*FIELDS, *(key for key in values if key.startswith("within_"))]
    return {key: values[key] for key in order}, judged.notes


def robot_source(robot: Robot) -> str:
    """Return what a robot is made of again, "" for one that comes with this project."""
    said = robot.description
    return "" if said.source is None else f"{said.source}, {said.base} to {said.tip}"


def _as_answered(rows: pd.DataFrame, answers: pd.DataFrame) -> pd.DataFrame:
    """Rows whose answers count as this pipeline's evaluation said: some solvers claim nothing."""
    if ANSWERED not in answers:
        return rows
    flags = answers.set_index("pose")[ANSWERED].reindex(rows.pose, fill_value=False)
    return rows.assign(answered=flags.to_numpy(dtype=bool))


def _counts(rows: pd.DataFrame, good: Flags, config: ReportConfig) -> dict[str, Any]:
    counted = good_trials(rows, config)
    return {
        "criterion": RATES.get(generator_of(rows), SOLVED),
        "trials": len(counted),
        "good": int(counted.sum()),
        "poses": len(rows),
        "good_poses": int(good.sum()),
        "claimed_and_wrong": int(rows.claimed_and_wrong.sum()),
        "outside_limits": int((~rows.within_limits).sum()),
    }


def _errors(rows: pd.DataFrame) -> dict[str, float]:
    """Errors of the joints that came back, whatever is claimed of them."""
    found = {}
    for name, (column, unit) in ERRORS.items():
        values = rows[column].to_numpy(dtype=float)
        found[f"{name}_mean_{unit}"] = float(values.mean())
        found[f"{name}_median_{unit}"] = float(np.median(values))
        found[f"{name}_p99_{unit}"] = float(np.quantile(values, 0.99))
    return found


def _self_colliding(rows: pd.DataFrame, good: Flags) -> int:
    """How many solved poses are so with joints that let the robot touch itself, where known."""
    if generator_of(rows) == UNREACHABLE:
        return 0
    return int((good & rows.self_collision.fillna(False).to_numpy(dtype=bool)).sum())


def _times(times: Array | None, good: Flags, config: LeaderboardConfig) -> dict[str, Any]:
    """Times of a call and how many poses are good within each of the limits; empty without."""
    limits = [within_name(limit) for limit in config.within_us]
    names = ("shift_us", "time_geometric_us", "time_median_us", "time_p99_us", *limits)
    if times is None:
        return dict.fromkeys(names, "")
    counts = [int((good & (times <= limit)).sum()) for limit in config.within_us]
    return dict(
        zip(
            names,
            [
                config.shift_us,
                shifted_geometric_mean(times, config.shift_us),
                float(np.median(times)),
                float(np.quantile(times, 0.99)),
                *counts,
            ],
            strict=True,
        )
    )
