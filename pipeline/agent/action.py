"""Actions that an agent may ask a body for, and the words that their targets are taken from.

A reply of the language model is free text with action tags in it (section III-E of the paper: "GPT
is allowed to embed action tags in the form of structured natural language in its output").
"""

from __future__ import annotations

from dataclasses import dataclass

KINDS = ("grasp", "push", "point", "look", "face", "speak", "done")
OF_OBJECTS = ("grasp", "push", "point")  # their target is an object in view
PLACES = ("left", "right", "ahead", "up", "down", "user")  # where a robot looks besides objects
FACES = ("neutral", "happiness", "sadness", "surprise", "anger", "fear", "disgust")


@dataclass(frozen=True)
class Action:
    """One action.

    Attributes:
        kind: One of `KINDS`.
        target: Name of an object in view (grasp, push, point, look), a place (look), or an
            expression (face); empty for speak and done.
        text: The words of a speak action; empty for the others.
    """

    kind: str
    target: str = ""
    text: str = ""

    def as_tag(self) -> str:
        """Return the action in the tag language."""
        if self.kind == "done":
            return "<done/>"
        return f"<{self.kind}>{self.text or self.target}</{self.kind}>"

    @property
    def is_physical(self) -> bool:
        """Whether an arm moves."""
        return self.kind in OF_OBJECTS
