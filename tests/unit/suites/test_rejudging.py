"""Answers from elsewhere: judged by their joints alone, and refused in a sentence."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from pipeline.evaluation.config import EvaluateConfig
from pipeline.suites.drawing import SuiteError
from pipeline.suites.generators import Suite
from pipeline.suites.judging import Judged, judge
from robots import Robot


def answers(suite: Suite) -> pd.DataFrame:
    """The answers of whoever knows the solutions."""
    joints = suite.problems.joints
    return pd.DataFrame(
        {
            "pose": np.arange(len(joints)),
            "q0": joints[:, 0],
            "q1": joints[:, 1],
            "suite_checksum": suite.checksum,
        }
    )


@pytest.fixture
def judged(tmp_path: Path, arm: Robot, warm: Suite, evaluate: EvaluateConfig) -> Any:
    def of(frame: pd.DataFrame) -> Judged:
        path = tmp_path / "mine.parquet"
        frame.to_parquet(path)
        return judge(path, "mine", warm, arm, evaluate, 0)

    return of


def test_known_solutions_are_found_and_no_time_is_believed(judged: Any, warm: Suite) -> None:
    given = answers(warm).sample(frac=1.0, random_state=1).assign(time_per_pose_us=1.0)
    made = judged(given)
    assert made.notes == []
    rows = made.rows
    assert rows.pose.tolist() == [0, 1, 2, 3, 4]
    assert rows.found.all()
    assert (rows.position_error_mm < 1e-4).all()
    assert rows.time_per_pose_us.isna().all()
    assert rows.solver_time_us.isna().all()
    assert (rows.known_distance == 0).all()
    assert set(rows.stratum) == {"near"}


@pytest.mark.parametrize("value", [np.nan, 1e7])
def test_what_is_wrong_with_answers_is_counted_and_named(
    judged: Any, warm: Suite, value: float
) -> None:
    frame = answers(warm)
    frame.loc[1, "q0"] = value
    frame.loc[2, "q1"] = 9.0
    frame.loc[3, ["q0", "q1"]] += 0.5
    made = judged(frame[:4])
    rows = made.rows
    assert rows.found.tolist() == [True, False, True, True, False]
    assert rows.reason.tolist() == ["", "joints were not finite", "", "", "no answer"]
    assert rows.within_limits.tolist() == [True, True, False, True, True]
    assert rows.claimed_and_wrong.tolist() == [False, False, True, True, False]
    assert made.notes == [
        "mine.parquet: 1 of 5 poses have no answer, the first is pose 4.",
        "mine.parquet: 1 of 5 poses have joints that are not finite, the first is pose 1.",
        "mine.parquet: 1 of 5 poses have joints outside their limits, the first is pose 2.",
        "mine.parquet: 2 of 5 poses are claimed but wrong, the first is pose 2.",
    ]


def test_what_a_solver_does_not_claim_is_not_found(judged: Any, warm: Suite) -> None:
    rows = judged(answers(warm).assign(found=[True, False, True, True, True])).rows
    assert rows.found.tolist() == [True, False, True, True, True]
    assert rows.reason[1] == "not found"


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda f: f.drop(columns="q1"), r"lacks the column\(s\) q1; expected .* q0 to q1"),
        (lambda f: f.drop(columns="suite_checksum"), "lacks the column.* suite_checksum"),
        (lambda f: f.assign(q2=0.0), "has a column q2, but two_link has 2 joints"),
        (lambda f: f.assign(suite_checksum="abc"), "checksum abc, and this is warm of two_link, v"),
        (lambda f: f.assign(q0="left"), "column q0 must hold numbers, got "),
        (lambda f: f.assign(found=1), "column found must hold true or false, got int64"),
        (lambda f: f.assign(pose=f.pose + 1), "row 4 is for pose 5; the suite has poses 0 to 4"),
        (lambda f: f.assign(pose=f.pose + 0.5), "row 0 is for pose 0.5"),
        (lambda f: f.assign(pose=[0, 1, 2, 2, 4]), "answers pose 2 twice"),
        (lambda f: f[:0], "checksum of no row"),
    ],
)
def test_what_cannot_be_judged_is_refused(
    judged: Any, warm: Suite, change: Any, words: str
) -> None:
    with pytest.raises(SuiteError, match=words):
        judged(change(answers(warm)))


def test_a_file_that_is_none(
    tmp_path: Path, arm: Robot, warm: Suite, evaluate: EvaluateConfig
) -> None:
    path = tmp_path / "mine.parquet"
    with pytest.raises(SuiteError, match=r"there is no .*mine.parquet"):
        judge(path, "mine", warm, arm, evaluate, 0)
    path.write_text("pose,q0\n")
    with pytest.raises(SuiteError, match="is not a readable Parquet file"):
        judge(path, "mine", warm, arm, evaluate, 0)


def test_a_no_needs_no_joints_and_a_claim_does(judged: Any, warm: Suite) -> None:
    frame = answers(warm).assign(q0=np.nan, found=[True, False, False, False, False])
    made = judged(frame)
    assert not made.rows.found.any()
    assert made.rows.reason.tolist() == ["joints were not finite", *["not found"] * 4]
    assert made.notes == [
        "mine.parquet: 1 of 5 poses have joints that are not finite, the first is pose 0."
    ]
