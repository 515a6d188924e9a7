"""Summaries of raw rows, worked out by hand."""

import numpy as np
import pandas as pd
import pytest
from synthetic import raw_rows, report_config

from pipeline.reporting.summary import apply_not_found, main_batch, successes, summarise
from pipeline.reporting.topics.pairs import compare_solvers


def four_rows():
    rows = raw_rows(poses=4)
    rows["position_error_mm"] = [0.5, 5.0, 50.0, 0.5]
    rows["rotation_error_deg"] = [0.5, 0.5, 0.5, 19.0]
    rows["paper_position_error_mm"] = [0.25, 2.5, 25.0, 0.25]
    rows["paper_rotation_error_deg"] = [0.25, 0.25, 0.25, 9.0]
    rows["found"] = [True, True, False, True]
    rows["answered"] = rows.found
    return rows


def test_an_unanswered_pose_counts_the_idle_error_or_none():
    rows = four_rows()
    idle = apply_not_found(rows, "idle")
    assert idle.position_error_mm.tolist() == [0.5, 5.0, 700.0, 0.5]
    assert idle.paper_position_error_mm.tolist() == [0.25, 2.5, 350.0, 0.25]
    left_out = apply_not_found(rows, "nan")
    assert left_out.position_error_mm.isna().tolist() == [False, False, True, False]
    assert rows.position_error_mm.tolist() == [0.5, 5.0, 50.0, 0.5]


def test_a_network_keeps_its_own_errors_whatever_it_claims():
    rows = four_rows().assign(answered=True)
    assert apply_not_found(rows, "idle").position_error_mm.tolist() == [0.5, 5.0, 50.0, 0.5]


def test_summary_by_hand():
    config = report_config(resamples=50)
    line = summarise(four_rows(), config).iloc[0]
    assert line.poses == 4
    assert line.position_error_mm_mean == pytest.approx((0.5 + 5 + 700 + 0.5) / 4)
    assert line.paper_position_error_mm_sd == pytest.approx(np.std([0.25, 2.5, 350, 0.25]))
    assert line.success_strict == pytest.approx(0.25)
    assert line.success_loose == pytest.approx(0.75)
    assert line.success_paper == pytest.approx(0.75)
    assert line.success_strict_low < 0.25 < line.success_strict_high
    assert line.found == pytest.approx(0.75)


def test_without_the_idle_error_failures_still_count_in_rates():
    line = summarise(four_rows(), report_config(not_found="nan")).iloc[0]
    assert line.position_error_mm_mean == pytest.approx(2.0)
    assert line.success_loose == pytest.approx(0.75)


def test_joint_limits_count_in_our_success_and_not_in_the_papers():
    rows = four_rows().assign(within_limits=[False, True, True, True])
    config = report_config()
    ours = successes(rows, "geodesic", config.success.loose)
    paper = successes(rows, "paper", config.success.paper)
    assert ours.tolist() == [False, True, False, True]
    assert paper.tolist() == [True, True, False, True]


def test_errors_are_read_off_the_batch_with_most_poses():
    rows = pd.concat([raw_rows(poses=50, batch_size=1), raw_rows(poses=20, batch_size=100)])
    summary = summarise(rows, report_config())
    assert main_batch(rows) == 1
    assert summary.set_index("batch_size").main.to_dict() == {1: True, 100: False}
    hundred = summary[summary.batch_size == 100].iloc[0]
    assert hundred.time_per_batch_mean_ms == pytest.approx(hundred.time_per_pose_mean_us / 10)


def test_a_solver_that_never_answers_has_no_mean_and_no_crash():
    rows = raw_rows(poses=5).assign(found=False, answered=False)
    line = summarise(rows, report_config(not_found="nan")).iloc[0]
    assert np.isnan(line.position_error_mm_mean)
    assert line.success_loose == 0.0


def test_pairs_are_compared_on_the_poses_both_have():
    first = raw_rows(solver="cycleik", poses=30)
    second = raw_rows(solver="lm", poses=20)
    pair = compare_solvers(pd.concat([first, second]), report_config()).iloc[0]
    assert pair.poses == 20
    nearer = (first.position_error_mm[:20] < second.position_error_mm).mean()
    assert pair.first_nearer == pytest.approx(nearer)
    assert pair.success_p_holm >= pair.success_p


def test_poses_of_another_test_set_are_not_compared():
    moved = raw_rows(solver="lm", poses=30).assign(target_x_m=5.0)
    rows = pd.concat([raw_rows(solver="cycleik", poses=30), moved])
    assert compare_solvers(rows, report_config()).empty


def test_a_batch_that_goes_through_the_poses_again_is_not_the_main_one():
    again = raw_rows(poses=120, batch_size=120).assign(pose=np.arange(120) % 50)
    summary = summarise(pd.concat([raw_rows(poses=50), again]), report_config())
    assert summary.set_index("batch_size").main.to_dict() == {1: True, 120: False}
    assert summary.calls.tolist() == [50, 1]
    assert summary.poses.tolist() == [50, 50]


def test_poses_and_training_seeds_are_kept_apart():
    seeds = [raw_rows(poses=60).assign(seed=seed) for seed in range(3)]
    for shift, rows in zip((-1.0, 0.0, 1.0), seeds, strict=True):
        rows["position_error_mm"] = 5.0 + shift  # trainings differ, poses do not
    line = summarise(pd.concat(seeds), report_config()).iloc[0]
    assert (line.poses, line.seeds) == (60, 3)
    assert line.position_error_mm_mean_low == pytest.approx(5.0)
    assert line.position_error_mm_mean_high == pytest.approx(5.0)
    assert line.position_error_mm_mean_seeds_low == pytest.approx(4.0, abs=0.4)
    assert line.position_error_mm_mean_seeds_high == pytest.approx(6.0, abs=0.4)
    one = summarise(seeds[0], report_config()).iloc[0]
    assert np.isnan(one.position_error_mm_mean_seeds_low)
    several = [rows.assign(position_error_mm=50.0, found=rows.pose < 40) for rows in seeds]
    line = summarise(pd.concat(several), report_config()).iloc[0]
    alone = summarise(several[0], report_config()).iloc[0]
    assert line.success_loose_high == pytest.approx(alone.success_loose_high)
