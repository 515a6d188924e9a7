"""Raw rows of suites that ask for more than a pose: freedoms, and reasons for a "no"."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import baselines
from baselines import Freedom, Solver
from pipeline.evaluation.cache import cache_key
from pipeline.evaluation.config import EvaluateConfig
from pipeline.evaluation.runner import evaluate_solver
from pipeline.evaluation.task import EvaluationTask
from pipeline.suites.generators import Suite, generate
from pipeline.suites.judging import judge
from pipeline.suites.problems import freedoms
from pipeline.suites.rows import with_abilities, with_problems
from robots import Robot, load_robot
from tests.suites import config_of

FIXTURES = Path(__file__).parents[2] / "fixtures"


@pytest.fixture(scope="module")
def mixed() -> Robot:
    return load_robot(urdf=FIXTURES / "mixed.urdf", tip="tool")


@pytest.fixture(scope="module")
def partial(mixed: Robot) -> Suite:
    return generate(mixed, config_of("partial"), 0)


@pytest.fixture
def rows_of(mixed: Robot, evaluate: EvaluateConfig) -> Callable[[Suite, Solver], pd.DataFrame]:
    def of(suite: Suite, solver: Solver) -> pd.DataFrame:
        poses, left_open = suite.problems.poses, freedoms(suite.problems)
        task = EvaluationTask(mixed, solver, poses, freedoms=left_open)
        rows = evaluate_solver(task, replace(evaluate, time_s=None))
        return with_abilities(with_problems(rows, suite, mixed), suite, solver)

    return of


def test_answers_are_judged_under_the_freedoms_and_nothing_more(
    mixed: Robot, partial: Suite, rows_of: Callable[[Suite, Solver], pd.DataFrame]
) -> None:
    rows = rows_of(partial, baselines.load("lm", mixed))
    assert set(rows.solved_as) == {"freedoms"}
    assert rows.found.mean() > 0.95
    assert (rows.position_error_mm[rows.found] < 0.11).all()
    assert (rows.rotation_error_deg[rows.found] < 0.006).all()
    assert not rows.claimed_and_wrong.any()
    position = rows.stratum == "position"
    assert (rows.rotation_error_deg[position] < 1e-5).all(), "no rotation is wrong there"
    assert np.isinf(rows.about_z_rad).all()


def test_a_solver_of_whole_poses_is_asked_for_those(
    mixed: Robot, partial: Suite, rows_of: Callable[[Suite, Solver], pd.DataFrame]
) -> None:
    lm = baselines.load("lm", mixed, iterations=100)
    of_poses = type("OfPoses", (type(lm),), {"abilities": frozenset()})
    rows = rows_of(partial, of_poses(mixed, **lm.settings))
    assert set(rows.solved_as) == {"whole pose"}
    assert rows.found.mean() < 0.7
    assert not rows.claimed_and_wrong.any()


def test_another_freedom_is_another_question(
    mixed: Robot, partial: Suite, evaluate: EvaluateConfig
) -> None:
    solver, poses = baselines.load("lm", mixed), partial.problems.poses
    asked = [None, freedoms(partial.problems), (Freedom(),) * len(poses)]
    keys = [
        cache_key(EvaluationTask(mixed, solver, poses, freedoms=one), evaluate) for one in asked
    ]
    assert len({str(key) for key in keys}) == 3


def test_answers_from_elsewhere_have_the_same_freedoms(
    mixed: Robot, partial: Suite, evaluate: EvaluateConfig, tmp_path: Path
) -> None:
    joints = partial.problems.joints
    frame = pd.DataFrame({f"q{k}": column for k, column in enumerate(joints.T)})
    frame = frame.assign(pose=np.arange(len(joints)), suite_checksum=partial.checksum)
    frame.to_parquet(tmp_path / "mine.parquet")
    rows = judge(tmp_path / "mine.parquet", "mine", partial, mixed, evaluate, 0).rows
    assert (rows.position_error_mm < 1e-4).all()
    assert (rows.rotation_error_deg < 1e-4).all()
    assert (rows.idle_position_error_mm > 1.0).mean() > 0.9


def test_reasons_are_held_against_the_kind_of_problem(
    mixed: Robot, rows_of: Callable[[Suite, Solver], pd.DataFrame]
) -> None:
    suite = generate(mixed, replace(config_of("unreachable"), poses=8), 0)
    rows = rows_of(suite, baselines.load("lm", mixed, iterations=500))
    assert not rows.found.any()
    beyond = rows.stratum.str.startswith("beyond")
    assert (rows.explained[beyond] == "out of reach").all()
    assert rows.explained[~beyond].isin(["orientation", "limits"]).all()
    assert rows.explained_right.all()
