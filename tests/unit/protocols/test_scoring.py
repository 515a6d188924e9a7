"""What protocols make of rows whose numbers are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pipeline.protocols.scoring import Score, ranks, rounded, score, statistic
from tests.protocol_rows import answers, protocol


def test_a_plain_score_by_hand() -> None:
    found = score(answers([0.5, 0.9, 1.0, 3.6], [100, 200, 300, 1400]), protocol())
    assert found == Score(targets=4, success=0.5, position=1.5, rotation=0.0, time=0.5)


def test_each_family_of_errors_is_its_own() -> None:
    rows = answers([0.5, 0.5], paper_position_error_mm=2.0, axis_position_error_mm=[0.1, 4.0])
    for kind, success, mean in (
        ("euclidean", 1.0, 0.5),
        ("axes_mean", 0.0, 2.0),
        ("each_axis", 0.5, 2.05),
    ):
        found = score(rows, protocol(success__errors=kind, errors__kind=kind))
        assert (found.success, found.position) == (success, mean)


def test_without_an_answer_the_idle_configuration_counts_or_what_came_back() -> None:
    rows = answers([0.5, 7.0], answered=[True, False])
    assert score(rows, protocol()).position == 3.75
    idle = score(rows, protocol(errors__not_found="idle"))
    assert (idle.position, idle.rotation) == (50.25, 45.0)


def test_limits_count_where_the_protocol_says_so() -> None:
    rows = answers([0.5, 0.5], within_limits=[True, False])
    assert score(rows, protocol()).success == 1.0
    assert score(rows, protocol(success__limits=True)).success == 0.5


def test_errors_of_the_successes_only_and_none_where_there_is_no_success() -> None:
    of_successes = protocol(errors__of="successes")
    assert score(answers([0.2, 0.4, 50.0]), of_successes).position == pytest.approx(0.3)
    assert math.isnan(score(answers([50.0]), of_successes).position)


def test_without_a_rule_nothing_is_a_success_and_all_errors_count() -> None:
    rules = protocol(success__errors="none", rank__by="position", errors__of="successes")
    found = score(answers([1.0, 50.0]), rules)
    assert math.isnan(found.success)
    assert found.position == 25.5


def test_all_draws_count_or_the_nearest_one() -> None:
    rows = answers([3.0, 0.5, 2.0, 9.0], 100.0, draws=2, batch_size=2)
    every = score(rows, protocol(draws=2, batch_sizes=[2]))
    best = score(rows, protocol(draws=2, batch_sizes=[2], best_draw=True))
    assert (every.targets, every.success, every.position) == (2, 0.25, 3.625)
    assert (best.targets, best.success, best.position) == (2, 0.5, 1.25)
    assert every.time == best.time == pytest.approx(0.2)  # of a call, all of its draws together


def test_statistics_by_hand() -> None:
    values = np.arange(101.0)
    assert (statistic(values, "mean"), statistic(values, "median")) == (50.0, 50.0)
    assert statistic(values, "p98") == pytest.approx(98.0)
    # (0 + 1) (3 + 1) (15 + 1) = 64, whose cube root is 4
    assert statistic(np.array([0.0, 3.0, 15.0]), "shifted_mean") == pytest.approx(3.0)
    assert math.isnan(statistic(np.empty(0), "mean"))


def of(**values: float) -> Score:
    return Score(
        **{"targets": 1, "success": 1.0, "position": 1.0, "rotation": 1.0, "time": 1.0} | values
    )


def test_equal_digits_tie_and_take_the_places_of_all_of_them() -> None:
    times = {
        "lm": of(time=0.01204),
        "placo": of(time=0.0116),
        "a": of(time=0.2),
        "b": of(time=0.01),
    }
    by_time = protocol(rank__by="time", rank__digits=2)
    assert ranks(times, by_time) == {"b": 1, "lm": 2, "placo": 2, "a": 4}
    assert ranks(times, protocol(rank__by="time", rank__digits=3))["lm"] == 3


def test_success_ranks_the_higher_and_who_has_no_value_is_last() -> None:
    shares = {"lm": of(success=0.9999), "placo": of(success=1.0), "a": of(success=math.nan)}
    assert ranks(shares, protocol()) == {"placo": 1, "lm": 2, "a": 3}
    assert rounded(0.99994, 4) == 0.9999
