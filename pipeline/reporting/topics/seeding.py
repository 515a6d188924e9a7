"""How much a neural seed gives a local solver: the same poses from home and from the seed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from pipeline.evaluation.statistics import holm, mcnemar, wilcoxon
from pipeline.presentation.columns import ROBOT, SOLVER, count, number, p_value, share, text, under
from pipeline.presentation.naming import solver_title
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig, tolerance_title
from pipeline.reporting.data import Topic
from pipeline.reporting.summary import apply_not_found, in_order, main_batch, successes

PAIRED = ["batch_size", "pose", "target_x_m"]  # pose 7 of another test set is another pose


def _saved(line: Mapping[str, float]) -> float:
    return line["time_home_us"] - line["time_seeded_us"]


COLUMNS = (
    ROBOT,
    SOLVER,
    text("seeded_by", "seed", convert=solver_title),
    count("batch_size", "batch size"),
    count("poses", "poses"),
    *under(
        "1 mm, 1 deg [%]",
        share("success_home", "home", decimals=2),
        share("success_seeded", "seed", decimals=2),
        share("success_difference", "Δ [points]", decimals=2, signed=True),
        p_value("success_p"),
    ),
    *under(
        "iterations, mean",
        number("iterations_home", "home"),
        number("iterations_seeded", "seed"),
    ),
    *under(
        "time per pose [µs]",
        number("time_home_us", "home, mean"),
        number("time_seeded_us", "seed, mean"),
        number("saved_us", "saved, mean", _saved, signed=True),
        number("time_difference_us", "Δ, paired median", signed=True),
        number("seed_time_us", "the seed itself"),
    ),
)


def seed_effects(home: pd.DataFrame, seeded: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    """Compare the rows of one solver and robot from home and from a neural seed.

    Args:
        home: Raw rows whose initial guess is the home configuration.
        seeded: Raw rows of the same solver from the answers of a neural one.
        config: Not-found policy and the tolerance of success.

    Returns:
        One line a batch size that both have: poses, success of both with McNemar's p,
        iterations and mean times of both [us], the median of the paired time differences with
        Wilcoxon's p, and the time of the seed itself [us a pose]. Success is given only at the
        batch size that answered most poses.
    """
    a, b = (_by_pose(rows, config) for rows in (home, seeded))
    both = a.join(b, how="inner", lsuffix="_home", rsuffix="_seeded").reset_index()
    lines = [_line(part) for _, part in both.groupby("batch_size")]
    if not lines:
        return pd.DataFrame()
    main = main_batch(both)
    for line in lines:
        if line["batch_size"] != main:
            line |= dict.fromkeys(("success_home", "success_seeded", "success_difference"))
            line["success_p"] = None
    names = {"robot": home.robot.iloc[0], "solver": home.solver.iloc[0]}
    names["seeded_by"] = seeded.seeded_by.iloc[0]
    return pd.DataFrame([{**names, **line} for line in lines])


def adjusted(effects: pd.DataFrame) -> pd.DataFrame:
    """Adjust the p-values of success by Holm, over the solvers of each robot."""
    if effects.empty:
        return effects
    p_values: dict[int, float] = {}
    for _, lines in effects[effects.success_p.notna()].groupby("robot"):
        found = holm({str(i): float(p) for i, p in lines.success_p.items()})
        p_values |= {int(i): p for i, p in found.items()}
    return effects.assign(success_p=pd.Series(p_values, dtype=float))


def same_budget(home: Mapping[str, Any], seeded: Mapping[str, Any]) -> bool:
    """Say from their provenance whether both rows had the same budget and settings."""
    keys = ("solver_budget", "solver_identity")
    return all(home.get(key) == seeded.get(key) for key in keys)


def neural_seeds(effects: pd.DataFrame, config: ReportConfig) -> Table:
    """How much a neural seed gives each solver, on the same poses from home and from the seed.

    Args:
        effects: Lines of `seed_effects`; may be empty.
        config: The tolerance of success.
    """
    return Table.of(
        in_order(effects),
        COLUMNS,
        name="neural_seeds",
        title="What a neural seed gives a local solver",
        caption="The same poses from the home configuration and from the answer of a network, with "
        f"the same budget. Success at {tolerance_title(config.success.strict)} "
        "(Euclidean, geodesic, joint limits kept); p by McNemar, adjusted by Holm over the solvers "
        "of a robot. Times are those of the solver alone: what the seed costs at that batch size "
        "stands beside them, and pays off where it is less than what it saves.",
    )


def _by_pose(rows: pd.DataFrame, config: ReportConfig) -> pd.DataFrame:
    counted = apply_not_found(rows, config.not_found)
    values = rows[[*PAIRED, "iterations", "time_per_pose_us", "seed_time_us"]].copy()
    values["reached"] = successes(counted, "geodesic", config.success.strict)
    return values.drop_duplicates(PAIRED).set_index(PAIRED)


def _line(both: pd.DataFrame) -> dict[str, Any]:
    rate = mcnemar(both.reached_seeded, both.reached_home)
    time = wilcoxon(both.time_per_pose_us_seeded, both.time_per_pose_us_home)
    return {
        "batch_size": int(both.batch_size.iloc[0]),
        "poses": len(both),
        "success_home": float(both.reached_home.mean()),
        "success_seeded": float(both.reached_seeded.mean()),
        "success_difference": rate.effect,
        "success_p": rate.p_value,
        "iterations_home": float(both.iterations_home.mean()),
        "iterations_seeded": float(both.iterations_seeded.mean()),
        "time_home_us": float(both.time_per_pose_us_home.mean()),
        "time_seeded_us": float(both.time_per_pose_us_seeded.mean()),
        "time_difference_us": time.effect,
        "time_p": time.p_value,
        "seed_time_us": float(both.seed_time_us_seeded.mean()),
    }


TOPIC = Topic(tables=(lambda data: neural_seeds(data.effects, data.config),))
