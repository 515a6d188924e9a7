"""What may follow in a reply of tags: the language that a model's decoding is held to.

    reply = { [blank] tag } [blank] "<done/>"

Tags are those of `tags.parse_reply`: allowed kinds, objects in view, places and expressions that
there are, and words to be said. A reply that is led to its end is one that the parser takes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection
from dataclasses import dataclass, field

from pipeline.agent.action import FACES, OF_OBJECTS, PLACES

DONE, OPENING, CLOSING = "<done/>", "<speak>", "</speak>"


@dataclass
class TagGrammar:
    """Follows a reply as it grows, and says what may stand next.

    Attributes:
        names: Labels of the objects in view.
        kinds: Actions that are allowed.
        most: Tags of a reply, the end among them.
        repeats: Times that one and the same tag may stand in a reply.
        longest: Characters that a tag may have to say.
        over: Whether the reply has ended.
    """

    names: Collection[str]
    kinds: Collection[str]
    most: int
    repeats: int
    longest: int
    over: bool = field(default=False, init=False)
    _pending: str = field(default="", init=False)  # what stands after the last whole tag
    _stood: Counter[str] = field(
        default_factory=Counter, init=False
    )  # how often each tag has stood

    def __post_init__(self) -> None:
        """Spell every tag that there is."""
        targets = {kind: [*self.names] for kind in OF_OBJECTS}
        targets |= {"look": [*self.names, *PLACES], "face": [*FACES]}
        self._tags = [f"<{k}>{t}</{k}>" for k in self.kinds for t in targets.get(k, ())]

    def continuations(self) -> set[str]:
        """Return what may stand up to the end of a tag; any beginning of one of these may follow.

        Within words that are said the end of that tag is one of them, and `left_to_say` says how
        many other characters there may be.
        """
        if self.over:
            return set()
        said, bracket, rest = self._said()
        if said is not None:
            ending = CLOSING.removeprefix(bracket + rest)
            return {ending} if any(c.isalnum() for c in said) else set()
        whole = [DONE]
        if self._stood.total() < self.most - 1:
            whole += [tag for tag in self._tags if self._stood[tag] < self.repeats]
            whole += [OPENING] if "speak" in self.kinds else []
        spaced = [*whole, *(f" {tag}" for tag in whole)]
        return {tag.removeprefix(self._pending) for tag in spaced if tag.startswith(self._pending)}

    def left_to_say(self) -> int:
        """Return how many characters without brackets may be said next; 0 outside such a tag."""
        said, bracket, _ = self._said()
        return 0 if said is None or bracket else self.longest - len(said)

    def follow(self, text: str) -> None:
        """Let the reply grow by a beginning of a continuation, or by words that are said."""
        self._pending += text
        tag = self._pending.removeprefix(" ")
        said, _, _ = self._said()
        if tag == DONE:
            self.over = True
        elif tag in self._tags or (said is not None and tag.endswith(CLOSING)):
            self._stood[tag] += 1
            self._pending = ""

    def _said(self) -> tuple[str | None, str, str]:
        """Words of the tag of speech that has begun, and the bracket and more of its end."""
        tag = self._pending.removeprefix(" ")
        if not tag.startswith(OPENING):
            return None, "", ""
        return tag.removeprefix(OPENING).partition("<")
