"""Many solutions of one pose: rows before and after refinement, their spread, and who can draw."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from pipeline.evaluation.config import SampleConfig
from pipeline.evaluation.sampling import (
    COLUMNS,
    SolutionSamplingError,
    drawn_rows,
    sample_rows,
    sampler_of,
    spread,
)
from pipeline.loading import load_solver
from robots import Robot, load_robot

CONFIG = SampleConfig(
    solver="drawn", poses=2, samples=6, references=3, seed=5, postures=2, pictured=0
)


class Drawn:
    """Draws near joints that it knows."""

    name = "drawn"

    def __init__(self, joints: NDArray[np.float64]) -> None:
        self.joints = joints

    def sample(self, poses: Any, count: int, seed: int) -> NDArray[np.float64]:
        noise = np.random.default_rng(seed).normal(0, 0.02, (len(poses), count, 7))
        return self.joints[:, None] + noise


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


def test_every_solution_has_a_row_before_and_after_refinement(panda: Robot) -> None:
    middle = (panda.lower + panda.upper) / 2
    joints = np.stack((middle, middle + 0.1))
    drawn: Any = Drawn(joints)
    rows = sample_rows(panda, drawn, panda.forward_kinematics(joints), CONFIG, 1e-6)
    named = {name for name in COLUMNS if name != "q0"} | {f"q{joint}" for joint in range(7)}
    assert set(rows.columns) == named
    assert len(rows) == 2 * 2 * 6 + 2 * 3
    before, after = (drawn_rows(rows, refined) for refined in (False, True))
    references = rows[rows.reference]
    assert references.found.all() and references.position_error_mm.max() < 0.1
    assert references["pose"].tolist() == [0] * 3 + [1] * 3
    own = references[references.starts == 1]
    assert own.q0.nunique() == len(own) > 2, "descents from starts of their own end apart"
    assert before.position_error_mm.min() > 1
    assert after.position_error_mm.max() < 0.1
    assert after.found.all() and (after.starts == 1).all()
    assert not before.found.any()
    assert rows.within_limits.all()
    assert before.pose.tolist() == [0] * 6 + [1] * 6
    moved = after.filter(regex=r"^q\d").to_numpy() - before.filter(regex=r"^q\d").to_numpy()
    assert 0 < np.abs(moved).max() < 0.3, "a refined solution stays near what was drawn"
    joints = rows[[f"q{joint}" for joint in range(7)]].to_numpy()
    assert rows.in_collision.tolist() == panda.in_collision(joints).tolist()
    alone = sample_rows(
        panda, drawn, panda.forward_kinematics(joints[:2]), replace(CONFIG, references=0), 1e-6
    )
    assert not alone.reference.any() and len(alone) == 24


def test_spread_is_the_standard_deviation_over_the_solutions_of_a_pose() -> None:
    rows = pd.DataFrame({"pose": [0, 0, 1, 1], "q0": [0.0, 1, 5, 5], "q1": [0.0, 2, 4, 8]})
    expected = [[0.5**0.5, 2**0.5], [0, 8**0.5]]
    np.testing.assert_allclose(spread(rows).to_numpy(), expected)


def test_a_solver_of_one_answer_is_refused(panda: Robot) -> None:
    with pytest.raises(SolutionSamplingError, match="'lm' gives one answer"):
        sampler_of(load_solver("lm", panda))


@pytest.mark.parametrize("change", [{"samples": 1}, {"postures": 7}, {"pictured": 2}, {"poses": 0}])
def test_samples_that_cannot_be_are_refused(change: dict[str, int]) -> None:
    with pytest.raises(ValueError, match=f"sample.{next(iter(change))}"):
        SampleConfig(**{**vars(CONFIG), **change})
