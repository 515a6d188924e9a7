"""Tables of suites: rates, times and errors of rows whose numbers are known."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from synthetic import raw_rows, report_config

from pipeline.data.tables import write_table
from pipeline.evaluation.statistics import wilson_interval
from pipeline.reporting.results import read_results
from pipeline.reporting.suite_leaders import leaders, quickest
from pipeline.reporting.topics.suites import partial, suites, tracking, unreachable

POSES = 100


def rows(solver, suite, solved, stratum="any", **columns):
    """`solved` of 100 poses at 0.1 mm, the others at 30 mm; a call takes 1, 2, ... 100 us."""
    made = raw_rows("panda", "lm", POSES)
    good = np.arange(POSES) < solved
    values = {
        "solver": solver,
        "suite": suite,
        "suite_generator": suite,
        "batch_size": 1,
        "stratum": stratum,
        "found": good,
        "answered": True,
        "position_error_mm": np.where(good, 0.1, 30.0),
        "rotation_error_deg": np.where(good, 0.1, 5.0),
        "time_per_pose_us": np.arange(POSES) + 1.0,
    }
    return made.assign(**{**values, **columns})


def records(make, **by_solver):
    given = {("panda", r.suite.iloc[0], solver): r for solver, r in by_solver.items()}
    return make(given, report_config()).records()


def test_success_time_and_the_error_of_the_missed():
    (line,) = records(suites, lm=rows("lm", "warm", 90))
    interval = wilson_interval(90, 100, 0.95)
    assert (line["success"], line["success_low"], line["success_high"]) == (
        0.9,
        interval.low,
        interval.high,
    )
    (late,) = records(suites, lm=rows("lm", "warm", 90, time_per_pose_us=np.arange(POSES) + 31.0))
    assert (line["quick"], late["quick"], late["success"]) == (0.9, 0.7, 0.9)
    assert line["time_median_ms"] == pytest.approx(50.5e-3)
    assert line["time_p99_ms"] == pytest.approx(99.01e-3)
    assert (line["position_error_mm"], line["rotation_error_deg"]) == (30.0, 5.0)


def test_nothing_missed_has_no_error():
    (line,) = records(suites, lm=rows("lm", "warm", 100))
    assert line["position_error_mm"] is None


def test_a_claim_where_nothing_can_be_reached_is_a_lie_however_near():
    given = rows("lm", "unreachable", 3, np.where(np.arange(POSES) < 50, "a", "b"))
    first, second = records(unreachable, lm=given)
    assert (first["stratum"], first["claimed"], first["success"]) == ("a", 3, 0.94)
    assert (second["stratum"], second["claimed"], second["success"]) == ("b", 0, 1.0)
    assert first["position_error_mm"] == pytest.approx((3 * 0.1 + 47 * 30) / 50)
    assert records(suites, lm=given) == []


def test_a_reason_that_is_true_is_counted_and_a_missing_one_is_no_lie():
    right = np.arange(POSES) < 80
    told, silent = (
        rows("lm", "unreachable", 0, explained_right=right),
        rows("pin", "unreachable", 0),
    )
    first, second = records(unreachable, lm=told, pinocchio=silent)
    assert first["explained_share"] == 0.8
    assert second["explained_share"] is None


def test_targets_in_part_have_a_table_of_their_own():
    kinds = np.where(np.arange(POSES) < 50, "position", "axis z")
    asked = rows("lm", "partial", 75, kinds, solved_as="freedoms")
    first, second = records(partial, lm=asked)
    assert (first["stratum"], first["solved_as"], first["success"]) == ("position", "freedoms", 1.0)
    assert (second["stratum"], second["success"]) == ("axis z", 0.5)
    (_, other) = records(partial, elsewhere=rows("elsewhere", "partial", 75, kinds))
    assert other["solved_as"] is None
    assert records(suites, lm=asked) == []


def trajectories(steps, solved=100):
    """Ten trajectories of ten waypoints at 100 Hz; the joint steps are given."""
    number = np.arange(POSES)
    return rows(
        "lm",
        "tracking",
        solved,
        "plain",
        trajectory=number // 10,
        step=number % 10,
        rate_hz=100.0,
        joint_step=np.where(number % 10 == 0, np.nan, steps),
        known_distance=np.where(number % 10 == 9, 0.5, 9.0),
        time_per_pose_us=np.where(number == 0, 20_000.0, 50.0),
    )


def test_a_trajectory_is_followed_if_every_waypoint_is_and_nothing_jumps():
    steps = np.full(POSES, 0.01)
    steps[[25, 27, 33]] = 0.2
    (line,) = records(tracking, lm=trajectories(steps, solved=95))
    assert (line["trajectories"], line["success"]) == (10, 0.7)  # two jump, one misses
    assert (line["jumps"], line["largest_step"], line["drift"]) == (3, 0.2, 0.5)
    assert line["in_period"] == pytest.approx(0.94)  # 95 solved, one of them late


def test_answers_without_times_are_never_in_time():
    given = trajectories(np.full(POSES, 0.01)).assign(time_per_pose_us=np.nan)
    (line,) = records(tracking, lm=given)
    assert line["in_period"] is None


def test_who_leads_is_certain_where_intervals_do_not_touch():
    given = {"lm": rows("lm", "warm", 99), "placo": rows("placo", "warm", 80)}
    line, quick = records(leaders, **given)
    assert (line["best"], line["second"], line["apart"]) == ("LM, compiled", "placo", "yes")
    assert (quick["rate"], quick["best_share"], quick["second_share"]) == (
        "within 0.1 ms",
        0.99,
        0.8,
    )
    assert records(leaders, lm=rows("lm", "warm", 99), placo=rows("placo", "warm", 96))[0][
        "apart"
    ] == ("no")
    assert records(leaders, lm=rows("lm", "warm", 99)) == []


def test_rows_of_an_earlier_suite_are_named_and_left_out(tmp_path):
    facts = {"suite_checksum": "new"}
    write_table(tmp_path / "suite/panda/warm.parquet", pd.DataFrame({"x": [1.0]}), facts)
    for solver, checksum in (("lm", "new"), ("placo", "old")):
        write_table(
            tmp_path / f"evaluate_suite/panda/warm/{solver}.parquet",
            rows(solver, "warm", 50),
            {"suite_checksum": checksum},
        )
    results = read_results(tmp_path)
    assert list(results.suites) == [("panda", "warm", "lm")]
    assert any("placo.parquet is of another version" in note for note in results.notes)


def test_of_those_that_are_level_the_quickest_leads():
    slow, fast = (
        rows(name, "warm", 100, time_per_pose_us=time + np.arange(POSES) / 100)
        for name, time in (("lm", 20.0), ("pinocchio", 8.0))
    )
    poor = rows("placo", "warm", 50, time_per_pose_us=1.0)
    (line,) = records(quickest, lm=slow, pinocchio=fast, placo=poor)
    assert (line["best"], line["second"], line["level"]) == ("Pinocchio LM", "LM, compiled", 2)
    times = 8.0 + np.arange(POSES) / 100
    assert line["best_us"] == pytest.approx(np.exp(np.log(times + 10.0).mean()) - 10.0)
    assert line["apart"] == "yes"
    assert 8.0 < line["best_us"] < line["best_high"] < line["second_low"] < line["second_us"] < 21.0


@pytest.mark.parametrize("reason", ["no answer", "joints were not finite"])
def test_silence_is_no_true_no(reason):
    given = rows("mine", "unreachable", 0)
    said = given.assign(reason=["out of reach"] * 40 + [reason] * 60)
    (line,) = records(unreachable, mine=said)
    assert (line["success"], line["claimed"]) == (0.4, 0)
