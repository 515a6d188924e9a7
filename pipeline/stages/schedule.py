"""In which order tasks run side by side, and how long that will take."""

from __future__ import annotations

import heapq
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import cache

Needs = Mapping[str, frozenset[str]]


@dataclass(frozen=True)
class Estimates:
    """What a task takes, by what it took before.

    Attributes:
        own: Seconds by the name of the task, measured on this machine.
        given: Seconds of one task by the name of its step, as the project gives them.
    """

    own: Mapping[str, float]
    given: Mapping[str, float]

    def seconds(self, task: str) -> float:
        """Return what a task takes [s], zero where nobody knows."""
        return self.own.get(task, self.given.get(step_of(task), 0.0))


def step_of(task: str) -> str:
    """Name of the step of the graph that a task is of: ``plan`` of ``plan@nico``."""
    return task.partition("@")[0]


def stale_tasks(needs: Needs, changed: Collection[str]) -> set[str]:
    """Return the tasks that changed and all that build on them."""

    @cache
    def is_stale(task: str) -> bool:
        return task in changed or any(is_stale(each) for each in needs[task])

    return {task for task in needs if is_stale(task)}


def priorities(needs: Needs, estimates: Estimates) -> dict[str, float]:
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
        return estimates.seconds(task) + max(map(longest, built_on[task]), default=0.0)

    return {task: longest(task) for task in needs}


def makespan(needs: Needs, tasks: Collection[str], estimates: Estimates, places: int) -> float:
    """Return how long some tasks take [s], as many at a time as there are places.

    Args:
        needs: What each task builds on.
        tasks: That are to run; others are done.
        estimates: What each takes.
        places: How many run side by side.
    """
    order = priorities(needs, estimates)
    left, done, now = set(tasks), set(needs) - set(tasks), 0.0
    running: list[tuple[float, str]] = []
    while left or running:
        for task in ready(needs, left, done, order)[: places - len(running)]:
            left.remove(task)
            heapq.heappush(running, (now + estimates.seconds(task), task))
        now, ended = heapq.heappop(running)
        done.add(ended)
    return now


def ready(
    needs: Needs, left: Collection[str], done: Collection[str], order: Mapping[str, float]
) -> list[str]:
    """Return the tasks whose inputs are there, the one with the longest way to go first."""
    able = [task for task in left if needs[task] <= set(done)]
    return sorted(able, key=lambda task: (-order[task], task))
