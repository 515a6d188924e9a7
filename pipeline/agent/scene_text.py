"""What is seen, as structured text at the end of each user turn; and back, for the policy.

Names of objects, the user's words and reports of outcomes come from outside. Before they enter a
prompt they are made harmless: one line, no brackets, a bounded length. So a model that repeats them
cannot utter a tag that way, and they cannot imitate a line of the scene.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

HEADING = "Objects in view (base frame in metres, x ahead of the robot, y to its left):"
NOTHING = "Objects in view: none."
OUTCOME = "Outcome: "
# What stands in place of the user's words; brackets, because no words of a user are these.
GO_ON = "[go on with the instruction, or say that it is fulfilled]"
SILENCE = "[nothing was said]"
NAME_CHARACTERS = 40
OUTCOME_CHARACTERS = 200

_LINE = re.compile(
    r'- "(?P<name>[^"\n]+)": x=(?P<x>-?\d+\.\d+) y=(?P<y>-?\d+\.\d+) side=(?P<side>\w+) '
    r"certainty=(?P<score>\d\.\d+)"
)
_UNSAFE = re.compile(r"[^A-Za-z0-9 _\-]+")
_BRACKETS = str.maketrans({"<": "(", ">": ")", "[": "(", "]": ")", "{": "(", "}": ")"})


@dataclass(frozen=True)
class Seen:
    """An object in view.

    Attributes:
        name: Class of the object, as the detector names it.
        position: x and y in the base frame [m].
        side: "left", "middle" or "right" of the robot.
        score: The detector's certainty, 0 to 1.
    """

    name: str
    position: tuple[float, float]
    side: str
    score: float


def seen_at(name: str, x: float, y: float, score: float, middle: float = 0.05) -> Seen:
    """Return what is seen at x, y [m, base frame]; the middle is where abs(y) <= middle [m]."""
    side = "middle" if abs(y) <= middle else "left" if y > 0 else "right"
    return Seen(name, (float(x), float(y)), side, float(score))


def labelled(sightings: Iterable[Seen]) -> dict[str, Seen]:
    """Return what is in view under labels that are safe in a prompt and differ from each other.

    Of several sightings of one name the most certain counts: an action names a class.
    """
    best: dict[str, Seen] = {}
    for each in sightings:
        if each.name not in best or each.score > best[each.name].score:
            best[each.name] = each
    labels: dict[str, Seen] = {}
    for each in best.values():
        stem = label(each.name)
        name, number = stem, 1
        while name.casefold() in (taken.casefold() for taken in labels):
            number += 1
            name = f"{stem}_{number}"
        labels[name] = each
    return labels


def label(name: str) -> str:
    """Return a name of letters, digits, blanks, "_" and "-" only, as short as a label is."""
    safe = _UNSAFE.sub("_", " ".join(name.split()))
    return re.sub(r"_{2,}", "_", safe)[:NAME_CHARACTERS].strip(" _-") or "object"


def harmless(text: str, longest: int) -> str:
    """Return foreign words as one line without brackets, at most ``longest`` characters."""
    printable = "".join(c if c.isprintable() else " " for c in text[: 4 * longest])
    return " ".join(printable.translate(_BRACKETS).split())[:longest].strip()


def user_text(instruction: str, labels: dict[str, Seen], outcomes: Sequence[str]) -> str:
    """Return a user turn: the instruction, the results of the last actions, what is seen now.

    Args:
        instruction: The user's words, harmless already.
        labels: What is seen, from `labelled`.
        outcomes: Results of the last actions.
    """
    lines = [instruction, ""]
    lines += [OUTCOME + harmless(each, OUTCOME_CHARACTERS) for each in outcomes]
    if not labels:
        return "\n".join([*lines, NOTHING])
    return "\n".join([*lines, HEADING, *(_line(name, each) for name, each in labels.items())])


def read_user_text(text: str) -> tuple[str, list[Seen]]:
    """Return the instruction and what is seen from a user turn; names are labels."""
    instruction, *rest = text.split("\n")
    matches = (_LINE.fullmatch(line) for line in rest)
    return instruction, [
        Seen(m["name"], (float(m["x"]), float(m["y"])), m["side"], float(m["score"]))
        for m in matches
        if m is not None
    ]


def _line(name: str, each: Seen) -> str:
    x, y = each.position
    return f'- "{name}": x={x:.3f} y={y:.3f} side={each.side} certainty={each.score:.2f}'
