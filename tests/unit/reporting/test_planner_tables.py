"""Plans on another curve are counted apart, and prove nothing about the requested path."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import pandas as pd
import pytest

from pipeline.presentation.published import read_published
from pipeline.presentation.table import Table
from pipeline.reporting.results import Results
from pipeline.reporting.topics.planner import planner, planner_flips, planner_routes

PUBLISHED = Path(__file__).parents[3] / "results" / "published_results.csv"
# Pair 0 follows the requested path, 1 is on another curve, 2 is stuck, 3 leaves the reach.
ROWS = pd.DataFrame(
    {
        "solver": "lm",
        "pair": [0, 1, 2, 3],
        "plan_time_ms": [1.0, 50.0, 90.0, 20.0],
        "tip_error_mm": [0.1, 0.2, 0.1, 0.3],
        "flips": [0, 0, 1, 0],
        "query_flips": [0, 1, 1, 0],
        "waypoints": 50,
        "waypoints_found": 50,
        "in_reach": [True, True, True, False],
        "continuous": [True, False, False, False],
        "rerouted": [False, True, False, True],
        "detour_mm": [0.0, 80.0, 0.0, 300.0],
        "length_m": [1.0, 1.5, 1.0, 3.0],
        "requested_length_m": 1.0,
        "collisions": [3, 0, 0, 2],
        "limit_violations": 0,
    }
)


@pytest.fixture
def results(tmp_path: Path) -> Results:
    found = Results(tmp_path)
    found.plan["nico"] = ROWS
    return found


def only(table: Table) -> dict[str, str]:
    (line,) = csv.DictReader(io.StringIO(table.to_csv()))
    return line


def test_both_shares_stand_side_by_side(results: Results) -> None:
    line = only(planner(results, read_published(PUBLISHED)))
    assert (line["in_reach"], line["continuous"]) == ("3", "1")
    assert float(line["requested_without_flip"]) == pytest.approx(1 / 3)
    assert float(line["without_flip"]) == pytest.approx(2 / 3)
    assert float(line["followed_without_flip"]) == 1.0
    assert float(line["tip_error_largest_mm"]) == 0.2


def test_other_curves_are_counted_in_reach_and_beyond(results: Results) -> None:
    line = only(planner_routes(results))
    assert (line["in_reach"], line["in_reach_rerouted"], line["in_reach_failed"]) == ("3", "1", "1")
    assert (line["beyond"], line["beyond_rerouted"]) == ("1", "1")
    assert float(line["detour_mm"]) == 80.0
    assert float(line["longer"]) == 1.5
    assert float(line["hit_requested"]) == 1.0
    assert float(line["hit_rerouted"]) == 0.5


def test_rows_from_before_there_were_other_curves_are_all_as_asked(results: Results) -> None:
    results.plan["nico"] = ROWS.drop(columns=["rerouted", "detour_mm"])
    assert planner_routes(results).rows == []
    line = only(planner(results, read_published(PUBLISHED)))
    assert line["requested_without_flip"] == line["without_flip"]


def test_bars_add_up_to_all_plans_in_reach(results: Results) -> None:
    (axis,) = planner_flips(results.plan).axes
    assert sum(bar.get_width() for bar in axis.patches) == pytest.approx(100.0)
    assert axis.get_title(loc="left") + axis.get_title() == "NICO: 3 paths in reach"
