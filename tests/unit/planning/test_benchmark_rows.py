"""What the rows of the planner benchmark say beside the plan."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd

import baselines
from baselines import Budget
from pipeline.config import compose
from pipeline.data.rows import RowCheckpoint
from pipeline.planning import benchmark as module
from pipeline.planning.benchmark import KEY, benchmark, prepared, shown_route
from robots import load_robot

ROBOT = load_robot("panda")
CONFIG = replace(compose(["profile=smoke"]).plan, pairs=4)


def test_a_path_is_judged_once_and_the_query_is_kept_beside_the_repair(
    tmp_path: Path, monkeypatch
) -> None:
    judged = []
    judge_path = module.judge_path

    def counted(*arguments):
        judged.append(arguments)
        return judge_path(*arguments)

    monkeypatch.setattr(module, "judge_path", counted)
    solvers = {name: baselines.load("lm", ROBOT) for name in ("lm", "again")}
    rows = benchmark(ROBOT, solvers, CONFIG, 2, RowCheckpoint(tmp_path / "rows.jsonl", KEY))
    assert len(judged) == 4
    first, second = (rows[rows.solver == name].reset_index(drop=True) for name in solvers)
    same = ["in_reach", "continuous", "flips", "query_flips", "tip_error_mm", "largest_step_rad"]
    assert first[same].equals(second[same])
    assert (rows.query_time_ms <= rows.plan_time_ms).all()
    assert (rows.flips <= rows.query_flips).all()
    assert (rows.in_reach | ~rows.continuous).all()
    untouched = rows[(rows.query_flips == 0) & (rows.query_waypoints_found == 50)]
    assert (untouched.tip_error_mm == untouched.query_tip_error_mm).all()


def test_only_budgets_of_time_are_shortened() -> None:
    short, long = (replace(CONFIG, time_s=time_s, threads=1) for time_s in (1e-3, 1.0))
    lm = prepared(baselines.load("lm", ROBOT, threads=2), short)
    assert lm.budget == Budget(iterations=5000)
    assert lm.threads == 1
    placo = baselines.load("placo", ROBOT)
    assert prepared(placo, short).budget == Budget(time_s=1e-3)
    assert prepared(placo, long).budget == Budget(time_s=1e-3)


def test_the_plan_that_is_drawn_has_the_median_detour_of_those_in_reach() -> None:
    rows = pd.DataFrame(
        {
            "solver": ["a", "b", "c", "d", "e"],
            "pair": [0, 1, 2, 3, 4],
            "rerouted": [True, True, True, True, False],
            "flips": 0,
            "in_reach": [True, True, True, False, True],
            "detour_mm": [5.0, 90.0, 20.0, 1.0, 0.0],
        }
    )
    assert shown_route(rows) == ("c", 2)
    assert shown_route(rows[3:]) == ("d", 3)
    assert shown_route(rows[4:]) is None
