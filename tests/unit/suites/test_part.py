"""The first trajectories of a suite: the same whatever follows, found by what was sent."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd
import pytest

from pipeline.suites.generators import Suite, generate
from pipeline.suites.part import answered_part, first_trajectories
from robots import load_robot
from tests.suites import config_of


@pytest.fixture(scope="module")
def suite() -> Suite:
    config = replace(config_of("tracking"), rates_hz=[10.0, 20.0])
    return generate(load_robot("nico"), config, 0)


def test_the_first_trajectory_is_the_same_however_many_follow(suite: Suite) -> None:
    alone = generate(
        load_robot("nico"), replace(config_of("tracking"), rates_hz=[10.0, 20.0], trajectories=1), 0
    )
    part = first_trajectories(suite, 1)
    assert (part.problems.poses == alone.problems.poses).all()
    assert part.checksum == suite.checksum != alone.checksum
    assert 0 < len(part.problems) < len(suite.problems)
    assert len(first_trajectories(suite, 9).problems) == len(suite.problems)


def test_what_was_sent_says_which_trajectories_were_answered(suite: Suite) -> None:
    one = len(first_trajectories(suite, 1).problems)
    for last, rows in ((0, one), (one - 1, one), (one, len(suite.problems))):
        sent = pd.DataFrame({"pose": range(last + 1)})
        assert len(answered_part(suite, sent).problems) == rows


@pytest.mark.parametrize("poses", [["a", None], [-1], [10**9], []])
def test_answers_that_make_no_sense_are_left_to_the_judge(
    suite: Suite, poses: list[object]
) -> None:
    assert answered_part(suite, pd.DataFrame({"pose": poses})) is suite
    assert answered_part(suite, pd.DataFrame({"other": poses})) is suite


def test_single_poses_have_no_trajectories() -> None:
    warm = generate(load_robot("nico"), config_of("warm"), 0)
    assert first_trajectories(warm, 1) is warm
