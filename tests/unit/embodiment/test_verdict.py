"""Classes of the paper from courses that are laid out by hand; no physics."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.agent import Action, Turn
from pipeline.embodiment.senses import View
from pipeline.embodiment.session import Course, Event
from pipeline.embodiment.things import Thing
from pipeline.embodiment.verdict import judge
from pipeline.grasping.outcome import Deed, Report
from pipeline.grasping.trial import Setup
from pipeline.perception.detection import Detection, Sighting

PLACE = np.array([0.40, -0.20, 0.83])
SUCCEEDED = Report(lifted=True, bin="left", kept=True)
MISSED = Report(pushed=0.0, touching=[0, 0], closing_share=0.9)
LOST = Report(lifted=True)


def a_thing(name: str = "pear") -> Thing:
    return Thing(7, Setup(0, 0, name, (0.40, -0.20), 0.0, np.zeros(2)))


def a_sighting(name: str = "pear", away: float = 0.0) -> Sighting:
    detection = Detection(name, 0.9, (0, 0, 9, 9), (4, 4))
    return Sighting(detection, PLACE + np.array([0.0, away, 0.0]))


def a_course(
    sightings: list[Sighting], events: list[Event] | None = None, problem: str = ""
) -> Course:
    turn = Turn([], "", problem, problem.split(":")[0])
    return Course(View(None, sightings), events or [], [turn])


def a_grasp(report: Report, thing: Thing | None, name: str = "pear", away: float = 0.0) -> Event:
    deed = Deed(report.bin is not None, "")
    sighting = a_sighting(name, away)
    return Event(0.0, Action("grasp", name), deed, sighting, None, thing, abs(away), report)


@pytest.mark.parametrize(
    ("report", "expected"),
    [(SUCCEEDED, "Success"), (MISSED, "Not Grasped"), (LOST, "Slipped")],
)
def test_what_was_seen_and_grasped_is_for_physics_to_say(report: Report, expected: str) -> None:
    thing = a_thing()
    verdict = judge(thing, PLACE, a_course([a_sighting()], [a_grasp(report, thing)]), 0.04)
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
        verdict = judge(a_thing(), PLACE, a_course(sightings, problem=problem), 0.04)
        assert (verdict.outcome, verdict.reason) == ("Detection", reason)


def test_a_grasp_beside_the_thing_is_detection_unless_it_succeeds() -> None:
    course = a_course([a_sighting(away=0.09)], [a_grasp(MISSED, None, away=0.09)])
    verdict = judge(a_thing(), PLACE, course, 0.04)
    assert verdict.outcome == "Detection"
    assert "90 mm beside" in verdict.reason
    course = a_course([a_sighting(away=0.09)], [a_grasp(SUCCEEDED, None, away=0.09)])
    assert judge(a_thing(), PLACE, course, 0.04).outcome == "Success"


def test_a_wrong_name_is_no_failure_if_the_grasp_succeeds() -> None:
    thing = a_thing()
    for report, expected in ((SUCCEEDED, "Success"), (MISSED, "Detection")):
        course = a_course([a_sighting("orange")], [a_grasp(report, thing, "orange")])
        verdict = judge(thing, PLACE, course, 0.04)
        assert (verdict.outcome, verdict.seen_as) == (expected, "orange")


def test_what_was_seen_but_not_asked_for_is_the_language_models() -> None:
    verdict = judge(a_thing(), PLACE, a_course([a_sighting()]), 0.04)
    assert (verdict.outcome, verdict.order) == ("LLM", 0)
    late = a_course([a_sighting()], problem="timeout: no answer in time")
    assert judge(a_thing(), PLACE, late, 0.04).reason == "timeout: no answer in time"
    thing = a_thing()
    push = Event(0.0, Action("push", "pear"), Deed(True, ""), a_sighting(), None, thing, 0.0)
    verdict = judge(thing, PLACE, a_course([a_sighting()], [push]), 0.04)
    assert (verdict.outcome, "push" in verdict.reason) == ("LLM", True)


def test_the_first_of_several_grasps_counts_and_its_own_before_one_meant_for_it() -> None:
    thing = a_thing()
    events = [a_grasp(MISSED, None, away=0.08), a_grasp(LOST, thing), a_grasp(SUCCEEDED, thing)]
    verdict = judge(thing, PLACE, a_course([a_sighting()], events), 0.04)
    assert (verdict.outcome, verdict.order) == ("Slipped", 2)


def test_another_thing_of_the_row_does_not_count() -> None:
    other = a_thing("orange")
    course = a_course([a_sighting()], [a_grasp(SUCCEEDED, other, "orange")])
    assert judge(a_thing(), PLACE, course, 0.04).outcome == "LLM"
