"""Poses among obstacles: what is known is free, what is plain is not, and both judges say so."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd

import baselines
from baselines import Solution
from pipeline.config import compose
from pipeline.evaluation.config import EvaluateConfig
from pipeline.evaluation.rows import raw_rows
from pipeline.reporting.topics.suites import cluttered
from pipeline.suites.generators import Suite, generate
from pipeline.suites.rows import AMONG_OBSTACLES, obstacles, with_problems
from pipeline.suites.verdicts import disagreements, free_by_bullet, free_by_coal, verdicts
from robots import Robot, load_robot
from tests.suites import config_of


@cache
def panda() -> Robot:
    return load_robot("panda")


@cache
def suite() -> Suite:
    return generate(panda(), config_of("cluttered"), 0)


def rows_of(joints: np.ndarray, evaluate: EvaluateConfig, given: bool) -> pd.DataFrame:
    count = len(joints)
    nothing, found = np.full(count, np.nan), np.ones(count, dtype=bool)
    solution = Solution(joints, found, nothing, np.zeros(count, dtype=np.int64), ("",) * count)
    rows = raw_rows(panda(), suite().problems.poses, [solution], nothing, evaluate, False)
    rows.insert(0, "pose", np.arange(count))
    return with_problems(rows.assign(batch_size=1), suite(), panda(), given)


def test_the_known_configuration_keeps_its_clearance_and_half_is_requested(
    evaluate: EvaluateConfig,
) -> None:
    rows = rows_of(suite().problems.joints, evaluate, True)
    assert {*AMONG_OBSTACLES} <= {*rows}
    assert rows.stratum.unique().tolist() == ["50 mm", "20 mm", "10 mm", "5 mm"]
    assert (rows.coal_distance_mm >= rows.clearance_mm - 1e-3).all()
    assert (rows.coal_distance_mm < rows.clearance_mm + 1.0).mean() > 0.8
    np.testing.assert_allclose(rows.requested_clearance_mm, rows.clearance_mm / 2)
    assert free_by_coal(rows).all()
    assert free_by_bullet(rows).all()
    assert not disagreements(rows).any()
    assert not rows.self_collision.any()


def test_plain_answers_collide(evaluate: EvaluateConfig) -> None:
    plain = baselines.load("lm", panda()).solve(suite().problems.poses).joints
    rows = rows_of(plain, evaluate, False)
    assert free_by_coal(rows).mean() < 0.2
    assert (free_by_coal(rows) == free_by_bullet(rows)).mean() > 0.95


def test_a_claim_that_is_not_free_is_counted(evaluate: EvaluateConfig) -> None:
    plain = baselines.load("lm", panda()).solve(suite().problems.poses).joints
    rows = rows_of(plain, evaluate, True)
    table = cluttered({("panda", "cluttered", "lm"): rows}, compose().report)
    wrong = sum(line["false_claims"] for line in table.records())
    assert wrong == int((~free_by_coal(rows)).sum()) > 20
    rows["obstacles_given"] = False
    table = cluttered({("panda", "cluttered", "lm"): rows}, compose().report)
    assert [line["false_claims"] for line in table.records()] == [0, 0, 0, 0]


def test_judges_that_differ_are_counted() -> None:
    sets = obstacles(suite().problems)
    assert sets is not None
    known = verdicts(panda(), suite().problems.joints[:3], sets[:3])
    rows = pd.DataFrame(known)
    rows.loc[0, "bullet_distance_mm"] += 1.5
    rows.loc[1, "bullet_self_gap_mm"] = -1.5
    rows.loc[2, "bullet_distance_mm"] += 0.5
    assert disagreements(rows).tolist() == [True, True, False]


def test_a_solver_that_is_given_the_obstacles_finds_most() -> None:
    problems, sets = suite().problems, obstacles(suite().problems)
    assert sets is not None
    solution = baselines.load("lm", panda()).solve(problems.poses, avoid=sets)
    assert solution.found.mean() > 0.85
    assert panda().clearance.free(solution.joints, sets)[solution.found].all()
