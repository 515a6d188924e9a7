"""The five classes of the paper (section IV-C), from what really lay there and what was done.

A trial is one object of a row. `Detection`: it was not seen where it lay, or taken for something
else, and so could not be grasped. `LLM`: it was seen, but the agent did not have it grasped. All
else is for the physics to say. As in the paper, a wrong name or place that leads to a successful
grasp all the same is no failure.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from pipeline.embodiment.scene_objects import Array, SceneObject
from pipeline.embodiment.session import Episode, Event
from pipeline.grasping.outcome import DETECTION, LANGUAGE, SUCCESS, classify


@dataclass(frozen=True)
class Verdict:
    """The outcome of one object of a row.

    Attributes:
        outcome: Class of the paper.
        reason: In words.
        attempt: The grasp that it was judged by; None if there was none.
        order: Number of that grasp in its row, from 1; 0 if there was none.
        attempts: Grasps where the object lay, or in its name where nothing lay.
        seen_as: Name under which it was seen where it lay; nothing if it was not.
        score: Certainty of that sighting, NaN if there was none.
        sighting_error: Distance from where it was seen to where it lay [m], NaN if not seen.
    """

    outcome: str
    reason: str
    attempt: Event | None
    order: int
    attempts: int
    seen_as: str
    score: float
    sighting_error: float


def judge(
    obj: SceneObject, at_first: Array, episode: Episode, located: float, once: bool = True
) -> Verdict:
    """Class one object of a row.

    Args:
        obj: The object.
        at_first: Where it lay when the agent was instructed, base frame [m], shape (3,).
        episode: How the instruction went.
        located: Distance within which a sighting is of the object that lies there [m].
        once: Whether the first grasp counts, as in the paper; else the last, or the one that
            succeeded.
    """
    attempt, order, attempts = _attempt(obj, episode, once)
    seen_as, score, error = _seen(obj.name, at_first, episode, located)
    if attempt is not None and attempt.sighting is not None:
        seen_as, score = attempt.sighting.name, attempt.sighting.score
        error = attempt.offset
    outcome, reason = _outcome(obj, at_first, episode, attempt, seen_as)
    return Verdict(outcome, reason, attempt, order, attempts, seen_as, score, error)


def _attempt(obj: SceneObject, episode: Episode, once: bool) -> tuple[Event | None, int, int]:
    """The grasp that an object is judged by.

    Where it counts once, the first where the object lay, or else the first in its name where
    nothing lay. Where it may be tried again, the one that brought it into a bin: nothing can become
    of it afterwards; or else the last of the former, or of the latter.

    Returns:
        The grasp, its number in the row, and how many there were for this object.
    """
    grasps = [event for event in episode.events if event.report is not None]
    here = [event for event in grasps if event.obj is obj]
    meant = [e for e in grasps if e.obj is None and e.action.target == obj.name]
    won = [event for event in (*here, *meant) if event.result.done]
    for event in (*here, *meant) if once else (*won, *here[::-1], *meant[::-1]):
        order = next(k for k, other in enumerate(grasps, start=1) if other is event)
        return event, order, len(here) + len(meant)
    return None, 0, 0


def _seen(name: str, place: Array, episode: Episode, located: float) -> tuple[str, float, float]:
    """Name, score and error of the sighting of an object in the first look; its own name first."""
    near = []
    for each in episode.view.sightings:
        away = float(np.linalg.norm(each.position[:2] - place[:2]))
        if away <= located:
            near.append((each.name != name, away, each))
    if not near:
        return "", float("nan"), float("nan")
    _, away, found = min(near, key=lambda item: item[:2])
    return found.name, found.score, away


def _outcome(
    obj: SceneObject, place: Array, episode: Episode, attempt: Event | None, seen_as: str
) -> tuple[str, str]:
    if attempt is not None and attempt.report is not None:
        outcome, reason = classify(attempt.report)
        if outcome == SUCCESS:
            return outcome, reason
        if attempt.obj is None:
            return DETECTION, f"seen {1e3 * attempt.offset:.0f} mm beside it: {reason}"
        if attempt.action.target != obj.name:
            return DETECTION, f"taken for {attempt.action.target}: {reason}"
        return outcome, reason
    if seen_as != obj.name:
        return DETECTION, _unseen(obj.name, place, episode, seen_as)
    if episode.problem:
        return LANGUAGE, episode.problem
    others = {e.action.kind for e in episode.events if e.obj is obj and e.report is None}
    if others:
        return LANGUAGE, f"not grasped, but requested to {' and '.join(sorted(others))}"
    return LANGUAGE, "seen, but no grasp of it was requested"


def _unseen(name: str, place: Array, episode: Episode, seen_as: str) -> str:
    """Why an object counts as not seen."""
    if seen_as:
        return f"seen as {seen_as}"
    away = [
        float(np.linalg.norm(each.position[:2] - place[:2]))
        for each in episode.view.sightings
        if each.name == name
    ]
    return f"seen {1e3 * min(away):.0f} mm from where it lay" if away else "not seen"
