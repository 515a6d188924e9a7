"""An instruction that is said again while something is left on the table; no physics."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pipeline.agent import Action, Turn
from pipeline.embodiment.body import Body
from pipeline.embodiment.perception import View
from pipeline.embodiment.scene_objects import SceneObject, SceneObjects
from pipeline.embodiment.session import Session
from pipeline.embodiment.trials import _so_often_each
from pipeline.grasping.outcome import ActionResult, GraspReport
from pipeline.grasping.placements import Setup
from pipeline.perception.detection import Detection, Sighting

PLACE = np.array([0.4, -0.2, 0.83])
PEAR = SceneObject(7, Setup(0, 0, "pear", (0.4, -0.2), 0.0, np.zeros(2)))
SUCCEEDED, MISSED = GraspReport(lifted=True, bin="left"), GraspReport()


class Table:
    """A pear that lies there until a grasp succeeds; the reports say which one does."""

    def __init__(self, reports: list[GraspReport], problem: str = "") -> None:
        self.reports, self.problem = list(reports), problem
        self.told: list[str] = []
        self.said: list[str] = []
        self.gone = False
        self.report_of_body = MISSED

    # What an agent does.
    def instruct(self, words: str, seen: list[Any]) -> Turn:
        self.said.append(words)
        if self.problem:
            return Turn([], "", self.problem, "timeout")
        grasps = [Action("grasp", each.name) for each in seen]
        return Turn([*grasps, Action("done")], "")

    def report(self, outcome: str) -> None:
        self.told.append(outcome)

    # What a body does.
    def act(self, kind: str, place: Any, name: str, body: int) -> ActionResult:
        self.report_of_body = self.reports.pop(0)
        self.gone = self.report_of_body is SUCCEEDED
        return ActionResult(self.gone, "in the left bin" if self.gone else "closed on nothing")

    # What perception and objects do.
    def look(self, scene: Any, objects: Any) -> View:
        sighting = Sighting(Detection("pear", 0.9, (0, 0, 9, 9), (4, 4)), PLACE)
        return View(None, [] if self.gone else [sighting])

    def nearest(self, place: Any) -> tuple[SceneObject, float]:
        return PEAR, 0.0

    def positions(self) -> Any:
        return PLACE[None]


class OneHand:
    """The body: time does not pass, and the table says what its last grasp came to."""

    scene = SimpleNamespace(time_s=0.0)

    def __init__(self, table: Table) -> None:
        self.table, self.act = table, table.act

    @property
    def report(self) -> GraspReport:
        return self.table.report_of_body


def session(table: Table, most: int) -> Session:
    agent, body, objects = cast(Any, table), cast(Body, OneHand(table)), cast(SceneObjects, table)
    return Session(agent, body, table, objects, 0.04, _so_often_each(most))


@pytest.mark.parametrize(
    ("reports", "most", "grasps"),
    [
        ([SUCCEEDED], 3, 1),  # nothing is left to insist on
        ([MISSED, SUCCEEDED], 3, 2),
        ([MISSED, MISSED, MISSED, SUCCEEDED], 3, 3),
        ([MISSED, SUCCEEDED], 1, 1),  # the paper's protocol
    ],
)
def test_the_sentence_is_said_again_until_the_table_is_clear(
    reports: list[GraspReport], most: int, grasps: int
) -> None:
    table = Table(reports)
    episode = session(table, most).insist("please", most)
    assert [event.report for event in episode.events] == reports[:grasps]
    assert table.said == ["please"] * grasps
    assert len(episode.turns) == grasps
    how = ["done" if report is SUCCEEDED else "failed" for report in reports[:grasps]]
    assert [told.split(",")[0] for told in table.told] == [f"grasp pear: {each}" for each in how]


def test_a_turn_that_failed_ends_it() -> None:
    table = Table([MISSED], problem="timeout: no answer in time")
    episode = session(table, 3).insist("please", 3)
    assert (episode.events, len(episode.turns)) == ([], 1)
    assert episode.problem.startswith("timeout")


def test_an_object_is_grasped_so_often_at_most() -> None:
    refuse, grasp = _so_often_each(2), Action("grasp", "pear")
    assert [refuse(grasp, PEAR) for _ in range(3)] == ["", "", "it has been tried already"]
    assert refuse(Action("push", "pear"), PEAR) == ""
    assert refuse(grasp, None) == ""
