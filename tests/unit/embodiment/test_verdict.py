"""Classes of the paper from courses that are laid out by hand; no physics."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.agent import Action, Turn
from pipeline.embodiment.perception import View
from pipeline.embodiment.scene_objects import SceneObject
from pipeline.embodiment.session import Episode, Event
from pipeline.embodiment.verdict import judge
from pipeline.grasping.outcome import ActionResult, GraspReport
from pipeline.grasping.placements import Setup
from pipeline.perception.detection import Detection, Sighting

PLACE = np.array([0.40, -0.20, 0.83])
SUCCEEDED = GraspReport(lifted=True, bin="left", kept=True)
MISSED = GraspReport(pushed=0.0, touching=[0, 0], closing_share=0.9)
LOST = GraspReport(lifted=True)


def an_object(name: str = "pear") -> SceneObject:
    return SceneObject(7, Setup(0, 0, name, (0.40, -0.20), 0.0, np.zeros(2)))


def a_sighting(name: str = "pear", away: float = 0.0) -> Sighting:
    detection = Detection(name, 0.9, (0, 0, 9, 9), (4, 4))
    return Sighting(detection, PLACE + np.array([0.0, away, 0.0]))


def an_episode(
    sightings: list[Sighting], events: list[Event] | None = None, problem: str = ""
) -> Episode:
    turn = Turn([], "", problem, problem.split(":")[0])
    return Episode(View(None, sightings), events or [], [turn])


def a_grasp(
    report: GraspReport, obj: SceneObject | None, name: str = "pear", away: float = 0.0
) -> Event:
    result = ActionResult(report.bin is not None, "")
    sighting = a_sighting(name, away)
    return Event(0.0, Action("grasp", name), result, sighting, None, obj, abs(away), report)


@pytest.mark.parametrize(
    ("report", "expected"),
    [(SUCCEEDED, "Success"), (MISSED, "Not Grasped"), (LOST, "Slipped")],
)
def test_what_was_seen_and_grasped_is_for_physics_to_say(
    report: GraspReport, expected: str
) -> None:
    obj = an_object()
    verdict = judge(obj, PLACE, an_episode([a_sighting()], [a_grasp(report, obj)]), 0.04)
    assert (verdict.outcome, verdict.order, verdict.seen_as) == (expected, 1, "pear")


@pytest.mark.parametrize(
    ("sightings", "reason"),
    [
        ([], "not seen"),
        ([a_sighting("orange", 0.01)], "seen as orange"),
        ([a_sighting("pear", 0.09)], "seen 90 mm from where it lay"),
    ],
)
def test_what_was_not_seen_where_it_lay_is_detection(
    sightings: list[Sighting], reason: str
) -> None:
    for problem in ("", "timeout: no answer in time"):
        verdict = judge(an_object(), PLACE, an_episode(sightings, problem=problem), 0.04)
        assert (verdict.outcome, verdict.reason) == ("Detection", reason)


def test_a_grasp_beside_the_object_is_detection_unless_it_succeeds() -> None:
    episode = an_episode([a_sighting(away=0.09)], [a_grasp(MISSED, None, away=0.09)])
    verdict = judge(an_object(), PLACE, episode, 0.04)
    assert verdict.outcome == "Detection"
    assert "90 mm beside" in verdict.reason
    episode = an_episode([a_sighting(away=0.09)], [a_grasp(SUCCEEDED, None, away=0.09)])
    assert judge(an_object(), PLACE, episode, 0.04).outcome == "Success"


def test_a_wrong_name_is_no_failure_if_the_grasp_succeeds() -> None:
    obj = an_object()
    for report, expected in ((SUCCEEDED, "Success"), (MISSED, "Detection")):
        episode = an_episode([a_sighting("orange")], [a_grasp(report, obj, "orange")])
        verdict = judge(obj, PLACE, episode, 0.04)
        assert (verdict.outcome, verdict.seen_as) == (expected, "orange")


def test_what_was_seen_but_not_requested_is_the_language_models() -> None:
    verdict = judge(an_object(), PLACE, an_episode([a_sighting()]), 0.04)
    assert (verdict.outcome, verdict.order) == ("LLM", 0)
    late = an_episode([a_sighting()], problem="timeout: no answer in time")
    assert judge(an_object(), PLACE, late, 0.04).reason == "timeout: no answer in time"
    obj = an_object()
    push = Event(0.0, Action("push", "pear"), ActionResult(True, ""), a_sighting(), None, obj, 0.0)
    verdict = judge(obj, PLACE, an_episode([a_sighting()], [push]), 0.04)
    assert (verdict.outcome, "push" in verdict.reason) == ("LLM", True)


def test_the_first_of_several_grasps_counts_and_its_own_before_one_meant_for_it() -> None:
    obj = an_object()
    events = [a_grasp(MISSED, None, away=0.08), a_grasp(LOST, obj), a_grasp(SUCCEEDED, obj)]
    verdict = judge(obj, PLACE, an_episode([a_sighting()], events), 0.04)
    assert (verdict.outcome, verdict.order, verdict.attempts) == ("Slipped", 2, 3)


@pytest.mark.parametrize(
    ("grasps", "outcome", "order"),
    [
        ("missed lost succeeded", "Success", 3),
        ("lost missed", "Not Grasped", 2),
        ("succeeded missed_beside", "Success", 1),  # a second sighting of what is in the bin
        ("lost succeeded_beside", "Success", 2),  # it had rolled away
        ("missed_beside lost missed_beside", "Slipped", 2),
        ("missed_beside missed_beside", "Detection", 2),
    ],
)
def test_with_second_chances_the_last_counts_unless_one_has_succeeded(
    grasps: str, outcome: str, order: int
) -> None:
    obj, reports = an_object(), {"missed": MISSED, "lost": LOST, "succeeded": SUCCEEDED}
    events = []
    for each in grasps.split():
        name, _, beside = each.partition("_")
        target = (None, 0.08) if beside else (obj, 0.0)
        events.append(a_grasp(reports[name], target[0], away=target[1]))
    verdict = judge(obj, PLACE, an_episode([a_sighting()], events), 0.04, once=False)
    assert (verdict.outcome, verdict.order) == (outcome, order)
    assert verdict.attempts == len(events)


def test_another_object_of_the_row_does_not_count() -> None:
    other = an_object("orange")
    episode = an_episode([a_sighting()], [a_grasp(SUCCEEDED, other, "orange")])
    assert judge(an_object(), PLACE, episode, 0.04).outcome == "LLM"
