"""The meaning of an instruction, and how one of several objects is chosen by its place."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from pipeline.agent.scene_text import Seen

ORDERS: dict[str, Callable[[Seen], float]] = {
    "left_to_right": lambda seen: -seen.position[1],
    "right_to_left": lambda seen: seen.position[1],
    "near_to_far": lambda seen: seen.position[0],
}
# Which coordinate tells the object of a selector, and its sign: the least one is meant.
EXTREMES = {"leftmost": (1, -1), "rightmost": (1, 1), "nearest": (0, 1), "farthest": (0, -1)}
MIDDLE = "middle"


@dataclass(frozen=True)
class Intent:
    """An action and its target; of speak the words."""

    kind: str
    target: str


@dataclass
class Understanding:
    """The meaning of an instruction.

    Attributes:
        intents: What to do, in order.
        remarks: What to say about what cannot be done.
        spared: Objects that are not to be touched.
        floating: Objects named without a verb.
    """

    intents: list[Intent] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)
    spared: list[str] = field(default_factory=list)
    floating: list[str] = field(default_factory=list)


def as_words(name: str) -> str:
    """Return a name as it is said."""
    return name.replace("_", " ")


def pick(selector: str, seen: Sequence[Seen]) -> str:
    """Return the name of the object at a place: leftmost, rightmost, nearest, farthest, middle."""
    if selector == MIDDLE:
        ranked = sorted(seen, key=lambda each: each.position[1])
        return ranked[len(ranked) // 2].name
    x_or_y, sign = EXTREMES[selector]
    return min(seen, key=lambda each: sign * each.position[x_or_y]).name


def article(word: str) -> str:
    """Return the indefinite article of a word."""
    return "an" if word[:1] in "aeiou" else "a"
