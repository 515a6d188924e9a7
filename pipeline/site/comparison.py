"""Two results folders side by side: every rate and error of both, and which differ for certain."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pandas as pd

from pipeline.presentation.columns import ROBOT, SOLVER, number, plain, text, under
from pipeline.presentation.origin import origin_of
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.data import ReportData
from pipeline.reporting.suite_measures import rates

KEYS = ["where", "robot", "solver", "what"]
NONE = "no interval"
METRICS = {  # of a line of the summary: what, name, factor to the unit, whether it has an interval
    "success, 1 mm and 1 deg [%]": ("success_strict", 100.0, True),
    "success, 10 mm and 20 deg [%]": ("success_loose", 100.0, True),
    "position error, mean [mm]": ("position_error_mm_mean", 1.0, True),
    "rotation error, mean [deg]": ("rotation_error_deg_mean", 1.0, True),
    "time a pose, median [µs]": ("time_per_pose_median_us", 1.0, False),
}


def comparison_table(
    first: ReportData, second: ReportData, names: tuple[str, str], config: ReportConfig
) -> Table:
    """Set the numbers of two results folders side by side.

    Args:
        first: Of A.
        second: Of B.
        names: How both are called.
        config: Confidence of intervals.
    """
    numbers = [*KEYS, "value", "low", "high"]  # named, for a folder may have none
    a, b = (
        pd.DataFrame(measures(data, config), columns=numbers).set_index(KEYS)
        for data in (first, second)
    )
    joined = a.join(b, how="outer", lsuffix="_a", rsuffix="_b", sort=False).reset_index()
    joined["difference"] = joined.value_b - joined.value_a
    joined["verdict"] = [verdict(line) for line in joined.to_dict("records")]
    sure = int((joined.verdict == "differs").sum())
    table = Table.of(
        joined,
        _columns(names),
        name="comparison",
        title="Numbers side by side",
        caption=f"Differs: the {config.confidence * 100:g} % intervals do not overlap, which is "
        f"stricter than a test of the difference: {sure} of {len(joined)}. Times have no interval.",
    )
    command = shlex.join(["python", "-m", "pipeline", "site", f"compare={second.results.folder}"])
    cards = [card for data in (first, second) for card in data.results.evaluated.values()]
    table.origin = origin_of(command, cards, first.profile)
    return table


def measures(data: ReportData, config: ReportConfig) -> Iterator[dict[str, Any]]:
    """Yield every number of a results folder that has a name in both: value, low and high."""
    for line in data.summary.to_dict("records"):
        where = f"evaluation, {line['batch_size']} a call"
        for what, (name, factor, sure) in METRICS.items():
            ends = [
                line.get(f"{name}_{end}", np.nan) if sure else np.nan for end in ("low", "high")
            ]
            key = dict(zip(KEYS, (where, line["robot"], line["solver"], what), strict=True))
            low, high = (factor * end for end in ends)
            yield {**key, "value": factor * line[name], "low": low, "high": high}
    for (robot, suite, solver), rows in data.results.suites.items():
        for what, rate in rates(rows, config).items():
            key = dict(zip(KEYS, (f"suite {plain(suite)}", robot, solver, what), strict=True))
            both = {"value": rate.estimate, "low": rate.low, "high": rate.high}
            yield {**key, "what": f"{what} [%]", **{end: 100 * x for end, x in both.items()}}


def verdict(line: Mapping[Any, Any]) -> str:
    """Say whether two numbers differ beyond their intervals."""
    if np.isnan(line["value_a"]) or np.isnan(line["value_b"]):
        return "only in one"
    if np.isnan([line[f"{end}_{side}"] for end in ("low", "high") for side in "ab"]).any():
        return NONE
    apart = line["low_a"] > line["high_b"] or line["low_b"] > line["high_a"]
    return "differs" if apart else "within"


def _columns(names: tuple[str, str]) -> tuple[Any, ...]:
    sides = [
        under(
            f"{side}: {name}",
            number(f"value_{side.lower()}", "value"),
            number(f"low_{side.lower()}", "from"),
            number(f"high_{side.lower()}", "to"),
        )
        for side, name in zip("AB", names, strict=True)
    ]
    return (
        text("where", "where"),
        ROBOT,
        SOLVER,
        text("what", "what"),
        *sides[0],
        *sides[1],
        number("difference", "B − A", signed=True),
        text("verdict", "beyond intervals"),
    )
