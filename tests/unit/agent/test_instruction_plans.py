"""What counts as a right plan, and the suite of instructions itself."""

from __future__ import annotations

from collections import Counter

import pandas as pd
import pytest

from pipeline.agent import Action, Turn
from pipeline.instructions.plans import CLASSES, SuiteError, classify, read_plan
from pipeline.instructions.suite import read_suite, rows_of
from pipeline.reporting.instructions import confusion, plan_success

NAMES = ("banana", "pear", "can")


def turn(plan: str, words: str = "") -> Turn:
    pairs = (each.split() for each in plan.split(", ") if each)
    said = [Action("speak", text=words)] if words else []
    return Turn([*said, *(Action(kind, target) for kind, target in pairs), Action("done")], "")


@pytest.mark.parametrize(
    ("plan", "right", "expected"),
    [
        ("grasp pear, grasp banana", "grasp banana + grasp pear", "right"),
        ("grasp pear, grasp banana", "grasp banana then grasp pear", "order"),
        ("grasp pear, grasp banana, grasp can", "grasp ALL", "right"),
        ("grasp pear, grasp banana", "grasp ALL", "missing"),
        ("grasp pear, grasp pear", "grasp pear", "too many"),
        ("grasp pear, grasp can", "grasp pear", "too many"),
        ("push pear", "grasp pear", "wrong"),
        ("grasp can", "1 of grasp pear + grasp can", "right"),
        ("grasp can, grasp pear", "1 of grasp pear + grasp can", "too many"),
        ("grasp can", "1-2 of grasp ALL", "right"),
        ("grasp can, grasp pear, grasp banana", "1-2 of grasp ALL", "too many"),
        ("grasp can", "2 of grasp ALL", "missing"),
        ("grasp can, look user", "grasp can then look user", "right"),
        ("grasp can, point can, grasp pear", "2 of grasp ALL then point can", "order"),
        ("grasp can", "ask", "wrong"),
    ],
)
def test_classes_of_plans(plan: str, right: str, expected: str) -> None:
    assert classify(turn(plan), [right], NAMES) == expected
    assert classify(turn(plan), [right, plan.replace(", ", " then ")], NAMES) == "right"


@pytest.mark.parametrize(
    ("words", "right", "expected"),
    [
        ("Which one?", "ask", "right"),
        ("Which one?", "refuse", "asked"),
        ("I can not.", "refuse", "right"),
        ("I can not.", "grasp pear", "said so"),
        ("", "nothing", "right"),
        ("", "refuse", "silent"),
    ],
)
def test_words_in_place_of_actions(words: str, right: str, expected: str) -> None:
    assert classify(turn("", words), [right], NAMES) == expected
    assert classify(Turn([], "", "loop: x", "loop"), [right], NAMES) == "no plan"


@pytest.mark.parametrize("text", ["grasp apple", "2 of", "grasp pear + "])
def test_sequences_that_are_not_possible_are_refused(text: str) -> None:
    with pytest.raises(SuiteError):
        read_plan(text, NAMES)


def test_the_suite_has_ten_instructions_a_family_of_which_five_are_held_out() -> None:
    suite = read_suite()
    counts = Counter((each.family, each.held_out) for each in suite)
    assert len(suite) == 120 == len({(each.says, each.scene) for each in suite})
    assert set(counts.values()) == {5}
    assert len(counts) == 24


def test_the_open_half_is_understood_and_no_instruction_moves_an_arm_wrongly(config) -> None:
    from pipeline.agent.loading import agent_factory

    suite = read_suite()
    rows = pd.DataFrame(rows_of(suite, agent_factory(config, "nicol"), "policy"))
    assert (rows[~rows["held_out"]]["class"] == "right").all()
    moved = rows["did"].str.contains("grasp|push|point")
    assert set(rows[moved]["class"]) == {"right"}
    table = plan_success(rows, 0.95)
    assert table.records()[-1]["open_share"] == 1.0
    assert [row["right"] for row in confusion(rows).records()][-1] == sum(rows["class"] == "right")
    assert set(rows["class"]) <= set(CLASSES)
