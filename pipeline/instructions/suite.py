"""The suite of instructions: what is said, in view and right to do; and rows of an agent."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from pipeline.agent import Agent, Seen, Turn, seen_at
from pipeline.instructions.plans import SuiteError, classify, done_of, read_plan

SUITE = Path(__file__).with_name("suite.yaml")
HALVES = {"held_out": True, "open": False}
DESK = "desk"  # the scene where none is named
ALL = "all families"  # the total; a family of the suite is called "all"


@dataclass(frozen=True)
class Instruction:
    """One instruction.

    Attributes:
        number: Its place in the suite, from 0.
        family: What it tests.
        held_out: Whether the policy was written without a look at it.
        says: The words.
        scene: Name of what is in view.
        seen: What is in view.
        right: Action sequences that fulfil it, any of them.
    """

    number: int
    family: str
    held_out: bool
    says: str
    scene: str
    seen: tuple[Seen, ...]
    right: tuple[str, ...]


def read_suite(path: Path = SUITE) -> list[Instruction]:
    """Return the instructions of a suite.

    Raises:
        SuiteError: A scene or a sequence of actions is not possible.
    """
    content = yaml.safe_load(path.read_text(encoding="utf-8"))
    return [Instruction(number, *facts) for number, facts in enumerate(_instructions(content))]


def _instructions(content: dict[str, Any]) -> Iterator[tuple[Any, ...]]:
    for half, held_out in HALVES.items():
        for family, listed in content[half].items():
            for each in listed:
                scene = each.get("scene", DESK)
                if scene not in content["scenes"]:
                    raise SuiteError(f"'{each['says']}': scene {scene} is none of the suite's")
                places = content["scenes"][scene]
                for text in each["right"]:
                    read_plan(text, places)
                seen = tuple(seen_at(name, x, y, 1.0) for name, (x, y) in places.items())
                yield family, held_out, each["says"], scene, seen, tuple(each["right"])


def rows_of(
    instructions: list[Instruction], agent: Callable[[], Agent], name: str
) -> Iterator[dict[str, Any]]:
    """Yield one raw row for each instruction: what an agent did with it, and what that is.

    Args:
        instructions: Of the suite.
        agent: Begins a conversation, one an instruction.
        name: How the agent is called in the rows.
    """
    for each in instructions:
        yield row_of(each, agent().instruct(each.says, each.seen), name)


def row_of(instruction: Instruction, turn: Turn, name: str) -> dict[str, Any]:
    """Return the raw row of an instruction: what an agent's first reply does, and what that is."""
    return {
        "number": instruction.number,
        "family": instruction.family,
        "held_out": instruction.held_out,
        "agent": name,
        "scene": instruction.scene,
        "says": instruction.says,
        "right": " | ".join(instruction.right),
        "did": ", ".join(done_of(turn)),
        "class": classify(turn, instruction.right, [seen.name for seen in instruction.seen]),
        "problem": turn.reason,
        "reply": turn.reply,
    }


def in_families(rows: pd.DataFrame) -> Iterator[tuple[str, pd.DataFrame]]:
    """Yield each family with its rows, in the order of the suite, then all families."""
    for family in dict.fromkeys(rows["family"]):
        yield str(family), rows[rows["family"] == family]
    yield ALL, rows
