"""Tasks side by side: what is stale, what comes first, and how long it takes."""

from __future__ import annotations

from itertools import permutations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pipeline.engine.order import makespan, priorities, ready, stale_tasks, step_of

NEEDS = {
    "dataset@a": frozenset[str](),
    "dataset@b": frozenset[str](),
    "train@a": frozenset({"dataset@a"}),
    "plan@a": frozenset({"train@a"}),
    "evaluate@b-lm": frozenset({"dataset@b"}),
    "report": frozenset({"plan@a", "evaluate@b-lm"}),
}
SECONDS = {
    "dataset@a": 1.0,
    "dataset@b": 1.0,
    "train@a": 30.0,
    "plan@a": 10.0,
    "evaluate@b-lm": 4.0,
    "report": 0.0,
}


@pytest.mark.parametrize("name", ["evaluate_seeded@b-lm", "evaluate_seeded-b-lm"])
def test_a_task_is_of_a_step_whoever_named_it(name: str) -> None:
    assert step_of(name) == "evaluate_seeded"
    assert step_of("report") == "report"


def test_what_builds_on_a_stale_task_is_stale() -> None:
    assert stale_tasks(NEEDS, {"train@a"}) == {"train@a", "plan@a", "report"}
    assert stale_tasks(NEEDS, set()) == set()


def test_the_longest_way_goes_first() -> None:
    order = priorities(NEEDS, SECONDS)
    assert order["dataset@a"] == 1 + 30 + 10
    assert order["dataset@b"] == 1 + 4
    assert ready(NEEDS, set(NEEDS), set(), order) == ["dataset@a", "dataset@b"]
    assert ready(NEEDS, {"train@a", "evaluate@b-lm"}, {"dataset@a"}, order) == ["train@a"]


@pytest.mark.parametrize(("places", "seconds"), [(1, 1 + 1 + 30 + 10 + 4), (2, 41), (9, 41)])
def test_makespan_by_hand(places: int, seconds: float) -> None:
    assert makespan(NEEDS, set(NEEDS), SECONDS, places) == seconds


def test_what_is_done_takes_no_time() -> None:
    assert makespan(NEEDS, {"plan@a", "report"}, SECONDS, 2) == 10
    assert makespan(NEEDS, set(), SECONDS, 2) == 0


@given(st.lists(st.floats(0.1, 50), min_size=1, max_size=6), st.integers(1, 3))
def test_it_lies_within_the_bound_of_list_scheduling(times: list[float], places: int) -> None:
    """Independent tasks, longest first: at most 4/3 of the best order there is (Graham 1969)."""
    needs = {str(i): frozenset[str]() for i in range(len(times))}
    seconds = {str(i): t for i, t in enumerate(times)}
    best = min(_greedy(order, places) for order in permutations(times))
    taken = makespan(needs, set(needs), seconds, places)
    assert best - 1e-9 <= taken <= best * 4 / 3 + 1e-9


def _greedy(times: tuple[float, ...], places: int) -> float:
    ends = [0.0] * places
    for seconds in times:
        first = ends.index(min(ends))
        ends[first] += seconds
    return max(ends)
