"""How objects are told by their place: the leftmost, the one next to another, in an order."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from pipeline.agent.scene_text import Seen

Measure = Callable[[Seen], float]
SELECTORS: dict[str, Measure] = {  # the object with the least is meant
    "leftmost": lambda seen: -seen.position[1],
    "rightmost": lambda seen: seen.position[1],
    "nearest": lambda seen: seen.position[0],
    "farthest": lambda seen: -seen.position[0],
}
MIDDLE = "middle"
SIDES = {"leftmost": "left", "rightmost": "right", MIDDLE: "middle"}  # where several objects are
ORDERS = {
    "left_to_right": SELECTORS["leftmost"],
    "right_to_left": SELECTORS["rightmost"],
    "near_to_far": SELECTORS["nearest"],
}
RELATIONS: dict[str, Callable[[Seen, Seen], bool]] = {  # behind: farther from the robot
    "left_of": lambda seen, anchor: seen.position[1] > anchor.position[1],
    "right_of": lambda seen, anchor: seen.position[1] < anchor.position[1],
    "behind": lambda seen, anchor: seen.position[0] > anchor.position[0],
    "in_front_of": lambda seen, anchor: seen.position[0] < anchor.position[0],
    "next_to": lambda seen, anchor: True,
    "nearest_to": lambda seen, anchor: True,
}


def distance(one: Seen, other: Seen) -> float:
    """Return how far two objects are from each other [m]."""
    return math.dist(one.position, other.position)


def middle(seen: Sequence[Seen]) -> Measure:
    """Return how far an object is from the one in the middle, from left to right [m]."""
    ranked = sorted(seen, key=SELECTORS["rightmost"])
    return lambda each: distance(each, ranked[len(ranked) // 2])


def is_between(seen: Seen, one: Seen, other: Seen) -> bool:
    """Whether an object is in the circle that has two others at the ends of its diameter."""
    centre = [(a + b) / 2 for a, b in zip(one.position, other.position, strict=True)]
    return seen not in (one, other) and 2 * math.dist(seen.position, centre) < distance(one, other)
