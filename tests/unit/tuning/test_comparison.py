"""The comparison: what a training costs, equal budgets, rows that are kept, and the verdict."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import t

from pipeline.config import compose
from pipeline.data.dataset import PoseSet
from pipeline.data.files import write_sealed_yaml
from pipeline.data.tables import read_table, write_table
from pipeline.errors import PipelineError
from pipeline.learning.factory import build_network
from pipeline.learning.trainer import Trainer
from pipeline.reporting.results import read_results
from pipeline.reporting.topics.tuning import tuned_against_table_one, welch
from pipeline.tuning.comparison import (
    Candidate,
    Keep,
    load_candidates,
    multiply_adds,
    run_comparison,
    spend,
)
from robots import load_robot

SMOKE = ["profile=smoke", "robot=nico", "train.kinematics=pytorch_kinematics"]


def test_a_weight_is_used_once_a_pose_and_of_experts_one_is_asked() -> None:
    robot = load_robot("nico")
    table_one = build_network(robot, compose(["experiment=table_one", "robot=nico"]).model)
    biases = 2270 + 560 + 1100 + 1990 + 2590 + 870 + robot.dof
    assert multiply_adds(table_one) == 11_514_096 - biases  # the parameters that Table I gives
    compact = build_network(robot, compose(["robot=nico"]).model)
    layers = 12 * 128 + 128 * 128 + 128 * 4 * robot.dof
    assert multiply_adds(compact) == layers + 64 * 12


@pytest.mark.parametrize(("poses", "available"), [(5e5, 1e6), (9.3e6, 1e6), (1e6, 1e6), (10, 1000)])
def test_a_schedule_spends_its_budget(poses: float, available: float) -> None:
    train = replace(compose(SMOKE).train, batch_size=300)
    made = spend(train, poses, int(available))
    assert made.poses <= available
    assert made.poses % 300 == 0
    assert abs(made.poses * made.epochs - poses) <= 300 * made.epochs
    assert made.learning_rate == train.learning_rate


def test_trainings_see_the_same_poses_differ_by_seed_and_are_kept(tmp_path: Path) -> None:
    overrides = ["tune.comparison.currency=poses", "tune.comparison.amount=400"]
    config = compose([*SMOKE, *overrides, "tune.comparison.replicates=2"])
    wide = replace(config.model, hidden=[96, 96])
    chosen = [
        Candidate("best", config.train, config.model),
        Candidate("table_one", replace(config.train, batch_size=50), wide),
    ]
    robot = load_robot("nico")
    joints = np.random.default_rng(0).uniform(robot.lower, robot.upper, (300, robot.dof))
    poses = PoseSet(robot.forward_kinematics(joints), joints)
    path, written = tmp_path / "rows.parquet", []

    def keep(rows: pd.DataFrame) -> None:
        written.append(len(rows))
        write_table(path, rows, {})

    rows = run_comparison(robot, config, chosen, (poses, poses.first(60)), path, keep)
    assert rows["name"].tolist() == ["best", "table_one"] * 2  # in turns
    assert (rows.poses_seen == 400).all()
    assert rows.multiply_adds[1] > rows.multiply_adds[0]
    assert rows.position_error_mm.nunique() == 4
    assert written == [1, 2, 3, 4]
    again = run_comparison(robot, config, chosen, (poses, poses.first(60)), path, keep)
    assert written == [1, 2, 3, 4]
    pd.testing.assert_frame_equal(again, rows)


def test_a_budget_of_seconds_is_kept_however_slow_the_machine_becomes(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    now, rates = [0.0], []
    monkeypatch.setattr("pipeline.learning.trainer.time.process_time", lambda: now[0])
    monkeypatch.setattr("pipeline.tuning.comparison._poses_per_second", lambda *_: 1000.0)
    made = Trainer.step

    def slow(self: Trainer, *args: Any) -> None:
        rates.append(self.learning_rate(args[2].step, args[3]))
        now[0] += 0.25 if now[0] < 5 else 0.5  # as if another program came
        made(self, *args)

    monkeypatch.setattr(Trainer, "step", slow)
    config = compose([*SMOKE, "tune.comparison.amount=10", "tune.comparison.replicates=2"])
    robot = load_robot("nico")
    joints = np.random.default_rng(0).uniform(robot.lower, robot.upper, (200, robot.dof))
    poses = PoseSet(robot.forward_kinematics(joints), joints)
    chosen = [Candidate("best", config.train, config.model)]
    rows = run_comparison(robot, config, chosen, (poses, poses), Path("none"), lambda _: None)
    assert rows.train_s.tolist() == [10.0, 10.0]
    assert rows.poses_seen.tolist() == [n * config.train.batch_size for n in (20 + 10, 20)]
    assert rates[20] == pytest.approx(config.train.learning_rate / 2, rel=0.1)  # half the time
    assert rates[-1] < 0.1 * config.train.learning_rate


def test_a_best_that_is_the_default_stays_apart_when_a_killed_comparison_goes_on(
    tmp_path: Path,
) -> None:
    overrides = ["tune.comparison.currency=poses", "tune.comparison.amount=200"]
    config = compose([*SMOKE, *overrides, "tune.comparison.replicates=2"])
    chosen = [Candidate(name, config.train, config.model) for name in ("best", "default")]
    robot = load_robot("nico")
    joints = np.random.default_rng(0).uniform(robot.lower, robot.upper, (200, robot.dof))
    poses = PoseSet(robot.forward_kinematics(joints), joints)
    path = tmp_path / "rows.parquet"

    def until(count: int) -> Keep:
        def keep(rows: pd.DataFrame) -> None:
            write_table(path, rows, {})
            if len(rows) == count:
                raise KeyboardInterrupt

        return keep

    for count in (1, 2, 3):
        with pytest.raises(KeyboardInterrupt):
            run_comparison(robot, config, chosen, (poses, poses), path, until(count))
        assert read_table(path)["name"].tolist() == (["best", "default"] * 2)[:count]
    rows = run_comparison(robot, config, chosen, (poses, poses), path, until(0))
    assert rows["name"].tolist() == ["best", "default"] * 2
    assert rows["run"].nunique() == 2 and rows["replicate"].tolist() == [0, 0, 1, 1]


def test_the_best_of_a_search_for_another_kind_of_model_is_refused(tmp_path: Path) -> None:
    config = compose([*SMOKE, "tune.comparison.candidates=[best,default,table_one]"])
    best = tmp_path / "best.yaml"
    write_sealed_yaml(
        best, "train: {learning_rate: 0.02}\nmodel: {hidden: [96]}\nof: {kind: mlp}\n"
    )
    found, plain, paper = load_candidates(config, best, compose)
    assert (found.train.learning_rate, found.model.hidden) == (0.02, [96])
    assert (plain.train, plain.model) == (config.train, config.model)
    assert paper.model.hidden == config.robot.table_one.hidden
    assert paper.train.learning_rate == config.robot.table_one.learning_rate
    write_sealed_yaml(best, "train: {}\nmodel: {}\nof: {kind: experts, model: compact}\n")
    with pytest.raises(PipelineError, match="set model=compact"):
        load_candidates(config, best, compose)


def test_welchs_interval_is_the_one_of_the_book() -> None:
    mine, theirs = np.array([1.0, 2.0, 3.0]), np.array([4.0, 5.0, 9.0])
    difference, low, high = welch(pd.Series(mine), pd.Series(theirs))
    parts = mine.var(ddof=1) / 3, theirs.var(ddof=1) / 3
    freedom = sum(parts) ** 2 / sum(part**2 / 2 for part in parts)
    half = t.ppf(0.975, freedom) * sum(parts) ** 0.5
    assert difference == pytest.approx(-4.0)
    assert (low, high) == (pytest.approx(-4 - half), pytest.approx(-4 + half))


def test_the_report_says_who_beats_table_one_and_who_is_not_shown_to(tmp_path: Path) -> None:
    rows = [
        {
            "robot": "nico",
            "name": name,
            "model": model,
            "parameters": 10,
            "currency": "seconds",
            "amount": 80.0,
            "train_s": 80.5,
            "multiply_adds": 2e12,
            "poses_seen": 1000,
            "position_error_mm": position + wobble,
            "rotation_error_deg": position / 2 + wobble,
            "success_10mm_20deg": 0.5,
        }
        for name, model, position in (
            ("best", "compact", 2.0),
            ("default", "compact", 29.8),
            ("table_one", "paper", 30.0),
        )
        for wobble in (-0.3, 0.0, 0.3)
    ]
    write_table(tmp_path / "compare_tuned" / "nico" / "trainings.parquet", pd.DataFrame(rows), {})
    table = tuned_against_table_one(read_results(tmp_path))
    shown = [dict(zip((c.name for c in table.columns), row, strict=True)) for row in table.shown()]
    assert [row["verdict"] for row in shown] == [
        "beats it",
        "not shown to be better in both errors",
        "–",
    ]
    assert shown[0]["name"] == "best of the search (compact)"
    assert shown[0]["position_difference"].startswith("−28 [−28.")
    assert table.notes == ["NICO: equal budget is 80 s of this machine's processor time each."]
