"""Experiments in the report, from drawn runs: losses, secondary goals, many solutions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pipeline.data.files import write_json
from pipeline.data.tables import write_table
from pipeline.reporting.report import make_report, make_table
from pipeline.reporting.results import read_results
from pipeline.reporting.topics.experiments import constraints, solutions
from pipeline.reporting.topics.losses import compare_losses, losses_figure, losses_table, verdict
from pipeline.reporting.topics.sampling import sampler_measures
from robots import load_robot
from tests.unit.reporting.synthetic import PUBLISHED, report_config

GOAL = {"joints": ["b", 2], "posture": 0.5, "weight": 0.1, "link": None, "pose": None}


def swept(root: Path, name: str, errors: list[float], **train: Any) -> Path:
    """Write what one run of a sweep leaves: card and curve."""
    folder = root / "sweep" / name
    place = folder / "train" / "panda" / "small"
    config = {"epochs": 10, "loss": "smooth", "replicate": 0, "constraints": [], **train}
    card = {"robot": "panda", "joint_names": ["a", "b", "c"]}
    write_json(
        place / "card.json", {**card, "config": {"train": config, "model": {"name": "small"}}}
    )
    curve = pd.DataFrame({"samples": np.arange(1, len(errors) + 1) * 100})
    curve["validation_position_error_mm"] = errors
    curve["validation_rotation_error_deg"] = np.array(errors) / 2
    curve.to_csv(place / "curve.csv", index=False)
    return folder


def losses_of(root: Path) -> Path:
    for run in range(3):
        swept(root, f"f{run}", [80, 60, 50, 40 + run], loss="former", replicate=run)
        swept(root, f"s{run}", [70, 39 + run, 20, 9 + run], loss="smooth", replicate=run)
    swept(root, "other", [1, 1, 1, 1], loss="smooth", epochs=20)
    return root


def test_losses_are_compared_among_runs_that_differ_in_nothing_else(tmp_path: Path) -> None:
    (comparison,) = compare_losses(read_results(losses_of(tmp_path)).swept)
    assert comparison.runs("former") == comparison.runs("smooth") == 3
    assert comparison.mean("smooth", "validation_position_error_mm").tolist() == [70, 40, 20, 10]
    # The former end at 41; the new are below that at the second of four validations.
    assert comparison.gain("validation_position_error_mm") == 2.0
    table = losses_table([comparison])
    new = dict(zip([column.name for column in table.columns], table.rows[0], strict=True))
    assert (new["validation_position_error_mm_least"], new["runs"]) == (9.0, 3)
    said = verdict([comparison])
    assert "10 / 5 mm / deg with the new losses against 41 / 20.5 with the former" in said
    assert "2 times sooner" in said and "does not test the paper's claim" in said
    assert len(losses_figure([comparison]).axes) == 2


def test_losses_that_never_reach_the_former_are_said_to_be(tmp_path: Path) -> None:
    swept(tmp_path, "f", [50, 10], loss="former")
    swept(tmp_path, "s", [70, 40], loss="smooth")
    (comparison,) = compare_losses(read_results(tmp_path).swept)
    assert comparison.gain("validation_position_error_mm") is None
    assert "final position error never, its rotation error never" in verdict([comparison])


def test_a_secondary_goal_is_set_beside_the_run_without(tmp_path: Path) -> None:
    for scale, distance, error in ((0, 0.9, 4.0), (1, 0.3, 5.5)):
        folder = swept(tmp_path, f"scale{scale}", [9], constraints=[GOAL], constraint_scale=scale)
        rows = pd.DataFrame({"batch_size": [1] * 4 + [100] * 2, "position_error_mm": error})
        rows["rotation_error_deg"] = error / 2
        rows["q0"], rows["q1"], rows["q2"] = 7.0, 0.5 + distance, 0.5 - distance
        rows.loc[4:, "q1"] = 99.0  # rows of another batch size only time
        write_table(folder / "evaluate" / "panda" / "cycleik.parquet", rows, {})
    table = constraints(read_results(tmp_path))
    free, held = (
        dict(zip([column.name for column in table.columns], row, strict=True)) for row in table.rows
    )
    assert free["distance_rad"] == pytest.approx(0.9) and free["reduction"] is None
    assert held["distance_rad"] == pytest.approx(0.3)
    assert held["reduction"] == pytest.approx(3.0)
    assert held["position_cost_mm"] == pytest.approx(1.5)
    assert held["goal"] == "b, 2 at 0.5, weight 0.1"


def test_a_goal_for_a_link_is_measured_where_the_link_is(tmp_path: Path) -> None:
    """Panda's elbow at idle lies at (-0.165, 0, 0.615) m (see robots/panda); turned by half a turn
    about the vertical at (0.165, 0, 0.615), 330 mm away."""
    goal = {"link": "panda_link4", "position": [-0.165, 0.0, 0.615], "pose": None, "weight": 1.0}
    home = load_robot("panda").home
    for scale, turn in ((0, np.pi), (1, 0.0)):
        folder = swept(tmp_path, f"scale{scale}", [9], constraints=[goal], constraint_scale=scale)
        rows = pd.DataFrame({f"q{joint}": [value] * 3 for joint, value in enumerate(home)})
        rows["q0"] += turn
        rows = rows.assign(batch_size=1, position_error_mm=1.0, rotation_error_deg=1.0)
        write_table(folder / "evaluate" / "panda" / "cycleik.parquet", rows, {})
    table = constraints(read_results(tmp_path))
    free, held = (
        dict(zip([column.name for column in table.columns], row, strict=True)) for row in table.rows
    )
    assert free["link_distance_mm"] == pytest.approx(330, abs=1)
    assert held["link_distance_mm"] == pytest.approx(0, abs=1)
    assert held["link_reduction"] > 300
    assert held["distance_rad"] is None


def sampled(root: Path) -> Path:
    rows = pd.DataFrame({"pose": np.repeat([0, 1], 4), "sample": np.tile(range(4), 2)})
    rows["q0"] = np.tile([0.0, 1.0, 0.0, 1.0], 2)
    rows["q1"] = np.array([0.0, 1, 0, 1, 0, 0, 0, 0])
    rows["q2"] = np.tile([0.0, -1.0, 0.0, -1.0], 2)
    both = [rows.assign(refined=False, found=False, starts=0, position_error_mm=30.0)]
    both.append(
        rows.assign(refined=True, found=True, starts=[1, 1, 1, 2] * 2, position_error_mm=0.01)
    )
    table = pd.concat(both, ignore_index=True).assign(rotation_error_deg=1.0)
    write_table(root / "sample" / "panda" / "null_space.parquet", table, {})
    return root


def test_many_solutions_of_one_pose_are_summed_up(tmp_path: Path) -> None:
    table = solutions(read_results(sampled(tmp_path)))
    drawn, refined = (
        dict(zip([column.name for column in table.columns], row, strict=True)) for row in table.rows
    )
    assert (drawn["poses"], drawn["samples"]) == (2, 4)
    assert (drawn["wide_median"], drawn["wide_least"], drawn["three_wide"]) == (2.5, 2, 0.5)
    assert (drawn["position_error_mm"], refined["position_error_mm"]) == (30.0, 0.01)
    assert drawn["found"] is None and refined["found"] == 1.0
    assert refined["left"] == 0.25
    assert str(drawn["spread_rad"]).startswith("0.58 0.29 0.58")


def test_experiments_alone_make_a_report(tmp_path: Path) -> None:
    sampled(losses_of(tmp_path))
    paths = make_report(tmp_path, PUBLISHED, report_config())
    page = paths.html.read_text()
    assert "Many solutions of one pose" in page and "times sooner" in page
    assert (paths.figures / "losses.png").exists()
    assert make_table(tmp_path, PUBLISHED, report_config(), "losses").rows
    assert "left nothing in" in page and "The sample stage has left nothing" not in page


def test_a_run_that_cannot_be_read_is_noted(tmp_path: Path) -> None:
    folder = swept(tmp_path, "broken", [1])
    (folder / "train" / "panda" / "small" / "card.json").write_text("{", encoding="utf-8")
    results = read_results(tmp_path)
    assert not results.swept
    assert any("broken" in note and "could not be read" in note for note in results.notes)


def test_draws_are_measured_against_references(tmp_path: Path) -> None:
    """Two solutions that lie apart; draws reach one of them, refined ones both."""
    parts = []
    for reference, refined, q0 in (
        (False, False, [0.0, 0.1]),
        (False, True, [0.0, 2.0]),
        (True, True, [0.0, 2.0]),
    ):
        part = pd.DataFrame({"pose": [0, 0], "sample": [0, 1], "q0": q0, "starts": 1})
        part["position_error_mm"] = [0.0, 0.0] if refined else [30.0, 10.0]
        part["rotation_error_deg"], part["within_limits"] = 0.5, True
        part["in_collision"] = [False, refined]
        parts.append(part.assign(reference=reference, refined=refined, found=refined))
    rows = pd.concat(parts, ignore_index=True)
    write_table(tmp_path / "sample" / "panda" / "flow.parquet", rows, {})
    results = read_results(tmp_path)
    drawn, refined_line = sampler_measures(results).records()
    assert (drawn["position_mean_mm"], drawn["position_best_mm"]) == (20, 10)
    assert (drawn["coverage"], refined_line["coverage"]) == (0.5, 1)
    assert (drawn["clusters"], drawn["in_collision"]) == (2, 0)
    assert refined_line["in_collision"] == 0.5
    assert [line["samples"] for line in solutions(results).records()] == [2, 2]
    assert sampler_measures(read_results(sampled(tmp_path / "older"))).rows == []
