"""Agreement of rankings, and what turned a pair, on rows where both are known by hand."""

from __future__ import annotations

import math
from itertools import combinations, product

import pytest

from pipeline.protocols.comparison import SAMPLE, TOGETHER, Ranking, kendall_tau, turns
from tests.protocol_rows import answers, protocol


def test_tau_by_hand() -> None:
    one = {"a": 1, "b": 2, "c": 3, "d": 4}
    assert kendall_tau(one, one) == 1.0
    assert kendall_tau(one, {"a": 4, "b": 3, "c": 2, "d": 1}) == -1.0
    # five pairs alike, one reversed: (5 - 1) / 6
    assert kendall_tau(one, {"a": 2, "b": 1, "c": 3, "d": 4}) == pytest.approx(4 / 6)
    # a and b tied: five alike, none reversed, 5 / sqrt(6 * 5)
    assert kendall_tau(one, {"a": 1, "b": 1, "c": 3, "d": 4}) == pytest.approx(5 / math.sqrt(30))


def test_tau_is_of_the_common_ones_and_of_nothing_where_all_tie() -> None:
    assert kendall_tau({"a": 1, "b": 2, "x": 3}, {"b": 2, "a": 1, "y": 3}) == 1.0
    assert math.isnan(kendall_tau({"a": 1, "b": 1}, {"a": 1, "b": 2}))
    assert math.isnan(kendall_tau({"a": 1}, {"a": 1}))


def test_tau_agrees_with_counting_pairs() -> None:
    for places in product((1, 2, 3), repeat=3):
        one, other = {"a": 1, "b": 2, "c": 2}, dict(zip("abc", places, strict=True))
        signs = [
            ((one[i] > one[j]) - (one[i] < one[j]), (other[i] > other[j]) - (other[i] < other[j]))
            for i, j in combinations("abc", 2)
        ]
        untied = [sum(pair[side] != 0 for pair in signs) for side in (0, 1)]
        if untied[1]:
            expected = sum(a * b for a, b in signs) / math.sqrt(untied[0] * untied[1])
            assert kendall_tau(one, other) == pytest.approx(expected)


PRECISE, SLOW = [0.1, 0.1, 0.1], 900.0
COARSE, FAST = [0.8, 0.8, 0.8], 100.0


def two(rules, near=PRECISE, far=COARSE, times=(SLOW, FAST)):
    """Solver `near` is precise and slow, `far` the reverse, unless it is said otherwise."""
    return Ranking(rules, {"near": answers(near, times[0]), "far": answers(far, times[1])})


def causes(one, other):
    (turn,) = turns({"one": one, "other": other})
    return turn.causes


def test_the_metric_turns_a_pair() -> None:
    by_error = protocol(title="E", rank__by="position")
    by_time = protocol(title="T", rank__by="time")
    (turn,) = turns({"e": two(by_error), "t": two(by_time)})
    assert (turn.first, turn.second) == ("near", "far")
    assert (turn.ahead_in, turn.behind_in, turn.causes) == ("E", "T", ("metric",))


def test_the_threshold_turns_a_pair() -> None:
    near, far = [0.1, 9.0, 9.0], [0.8, 0.8, 0.8]
    strict, loose = protocol(success__position_mm=0.5), protocol(success__position_mm=1.0)
    assert causes(two(strict, near, far), two(loose, near, far)) == ("success threshold",)


def test_the_statistic_turns_a_pair() -> None:
    near, far = [0.1, 0.1, 9.0], COARSE
    mean = protocol(rank__by="position")
    median = protocol(rank__by="position", errors__statistic="median")
    assert causes(two(mean, near, far), two(median, near, far)) == ("statistic of errors",)


def test_who_is_counted_turns_a_pair() -> None:
    rows = {"near": answers([0.1, 3.0], answered=[True, False]), "far": answers([2.0, 2.0])}
    own, idle = (
        protocol(rank__by="position", errors__not_found=policy) for policy in ("own", "idle")
    )
    assert causes(Ranking(own, rows), Ranking(idle, rows)) == ("who is counted",)


def test_what_the_rows_were_made_with_turns_a_pair() -> None:
    same = protocol(rank__by="time")
    reverse = two(same, times=(FAST, SLOW))
    assert causes(two(same), reverse) == (SAMPLE,)
    other = protocol(rank__by="time", start="none", draws=2, time_s=1e-3)
    assert causes(two(same), two(other, times=(FAST, SLOW))) == ("start, budget or calls",)
    near_home = protocol(rank__by="time", targets="near_home", within_deg=[3.0])
    assert causes(two(same), two(near_home, times=(FAST, SLOW))) == ("targets",)


def test_several_elements_turn_a_pair_together_only() -> None:
    by_error = protocol(rank__by="position", success__position_mm=1.0)
    by_success = protocol(rank__by="success", success__position_mm=0.5)
    # Here the first is nearer, all succeed at 1 mm, and at 0.5 mm only the second does, once.
    one = two(by_error, [0.6, 0.6], [0.4, 0.9], (FAST, FAST))
    # Here the second is ahead by either metric, and at 1 mm nobody is.
    other = two(by_success, [0.9, 0.9], [0.1, 0.1], (FAST, FAST))
    assert causes(one, other) == (TOGETHER,)


def test_ties_turn_nothing_and_only_common_solvers_are_compared() -> None:
    by_success, by_time = two(protocol()), two(protocol(rank__by="time"))
    assert by_success.ranks == {"near": 1, "far": 1}
    assert list(turns({"one": by_success, "other": by_time})) == []
    alone = Ranking(protocol(rank__by="time"), {"near": answers(PRECISE)})
    assert list(turns({"one": by_success, "other": alone})) == []
