"""In which order tasks run side by side, and how long that will take."""

from __future__ import annotations

import heapq
import re
from collections.abc import Collection, Mapping
from functools import cache

Needs = Mapping[str, frozenset[str]]
Seconds = Mapping[str, float]


def step_of(task: str) -> str:
    """Name of the step of the graph that a task is of: ``plan`` of ``plan@nico``, ``plan-nico``."""
    return re.split("[@-]", task)[0]


def stale_tasks(needs: Needs, changed: Collection[str]) -> set[str]:
    """Return the tasks that changed and all that build on them."""

    @cache
    def is_stale(task: str) -> bool:
        return task in changed or any(is_stale(each) for each in needs[task])

    return {task for task in needs if is_stale(task)}


def priorities(needs: Needs, seconds: Seconds) -> dict[str, float]:
    """Return how long it takes from the begin of each task to the end of all that build on it [s].

    The task with the longest way to go comes first (Graham, "Bounds on multiprocessing timing
    anomalies", SIAM Journal on Applied Mathematics 1969: list scheduling).
    """
    built_on: dict[str, list[str]] = {task: [] for task in needs}
    for task, inputs in needs.items():
        for each in inputs:
            built_on[each].append(task)

    @cache
    def longest(task: str) -> float:
        return seconds[task] + max(map(longest, built_on[task]), default=0.0)

    return {task: longest(task) for task in needs}


def makespan(needs: Needs, tasks: Collection[str], seconds: Seconds, places: int) -> float:
    """Return how long some tasks take [s], as many at a time as there are places.

    Args:
        needs: What each task builds on.
        tasks: That are to run; others are done.
        seconds: What each takes.
        places: How many run side by side.
    """
    needs = among(needs, tasks)
    order = priorities(needs, seconds)
    left, done, now = set(tasks), set[str](), 0.0
    running: list[tuple[float, str]] = []
    while left or running:
        for task in ready(needs, left, done, order)[: places - len(running)]:
            left.remove(task)
            heapq.heappush(running, (now + seconds[task], task))
        now, ended = heapq.heappop(running)
        done.add(ended)
    return now


def among(needs: Needs, tasks: Collection[str]) -> Needs:
    """Return what each of some tasks builds on among them, the others being done."""
    return {task: needs[task] & {*tasks} for task in tasks}


def ready(
    needs: Needs, left: Collection[str], done: Collection[str], order: Mapping[str, float]
) -> list[str]:
    """Return the tasks whose inputs are there, the one with the longest way to go first."""
    able = [task for task in left if needs[task] <= {*done}]
    return sorted(able, key=lambda task: (-order[task], task))
