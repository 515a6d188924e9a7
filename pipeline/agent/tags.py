"""The tag language: a reply in, actions in order out, or one named error; nothing else.

    reply   = { text | "<" kind ">" content "</" kind ">" | "<done/>" }
    kind    = grasp | push | point | look | face | speak | done
    text    = characters but "<" and ">", at least one of them a letter or digit to be said
    content = characters but "<" and ">"

Text is said where it stands. Tags do not nest, have no attributes and are lower-case. A reply has
at least one tag. A bracket anywhere else makes the whole reply invalid: none of it is carried out.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterator

from pipeline.agent.action import FACES, KINDS, OF_OBJECTS, PLACES, Action
from pipeline.agent.errors import Reason, TagError

LONGEST = 4000  # characters of a reply
MOST = 20  # actions with a tag in a reply
REPEATS = 3  # times that one and the same action may stand in a reply

_OPENING = re.compile(r"<([^<>/]{0,40})(/?)>")
_BRACKET = re.compile(r"[<>]")
_SPOKEN = re.compile(r"[^\W_]")


def parse_reply(
    reply: str,
    names: Collection[str],
    *,
    kinds: Collection[str] = KINDS,
    longest: int = LONGEST,
    most: int = MOST,
    repeats: int = REPEATS,
) -> list[Action]:
    """Read a reply strictly.

    Args:
        reply: Any string.
        names: Objects in view. A target is one of them up to case, and "_" or "-" for a blank.
        kinds: Actions that are allowed.
        longest: Characters that a reply may have.
        most: Actions with a tag that a reply may have.
        repeats: Times that one and the same action may stand in a reply.

    Returns:
        The actions in order. Targets are spelt as in ``names``; free text is a speak, if that is
        allowed.

    Raises:
        TagError: The reply is not in the language, or names what is not in view or not allowed.
    """
    if len(reply) > longest:
        raise TagError(
            Reason.TOO_LONG, f"a reply has at most {longest} characters, got {len(reply)}"
        )
    actions: list[Action] = []
    tags = 0
    counts: Counter[Action] = Counter()
    for kind, content in _elements(reply):
        if kind is None:
            if "speak" in kinds and _SPOKEN.search(content):
                actions.append(Action("speak", text=_one_line(content)))
            continue
        action = _action(kind, content, names, kinds)
        tags += 1
        counts[action] += 1
        if tags > most:
            raise TagError(Reason.TOO_MANY_ACTIONS, f"a reply has at most {most} actions")
        if counts[action] > repeats:
            raise TagError(
                Reason.LOOP, f"{action.as_tag()} stands more than {repeats} times in a reply"
            )
        actions.append(action)
    if not tags:
        raise TagError(Reason.NO_ACTION, "a reply has at least one tag, <done/> if nothing else")
    return actions


def _elements(reply: str) -> Iterator[tuple[str | None, str]]:
    """Yield (kind, content) of each tag, and (None, text) of what stands between tags."""
    at = 0
    while (bracket := _BRACKET.search(reply, at)) is not None:
        yield None, reply[at : bracket.start()]
        opening = _OPENING.match(reply, bracket.start())
        if opening is None:
            raise TagError(Reason.HALF_TAG, f"'{_near(reply, bracket.start())}' is no whole tag")
        kind, single = opening.group(1), bool(opening.group(2))
        if kind not in KINDS:
            valid = ", ".join(KINDS)
            raise TagError(Reason.UNKNOWN_ACTION, f"no action '{_show(kind)}'. Valid: {valid}")
        if single:
            if kind != "done":
                raise TagError(Reason.BAD_TARGET, f"<{kind}/> says no target")
            yield kind, ""
            at = opening.end()
            continue
        closing = f"</{kind}>"
        end = _BRACKET.search(reply, opening.end())
        if end is None or not reply.startswith(closing, end.start()):
            raise TagError(Reason.HALF_TAG, f"<{kind}> is not closed by {closing}")
        yield kind, reply[opening.end() : end.start()]
        at = end.start() + len(closing)
    yield None, reply[at:]


def _action(kind: str, content: str, names: Collection[str], kinds: Collection[str]) -> Action:
    if kind not in kinds:
        raise TagError(Reason.UNKNOWN_ACTION, f"the action '{kind}' is not allowed here")
    words = _one_line(content)
    if kind == "speak":
        if not _SPOKEN.search(words):
            raise TagError(Reason.BAD_TARGET, "<speak> has nothing to say")
        return Action(kind, text=words)
    if kind == "done":
        if words:
            raise TagError(Reason.BAD_TARGET, "<done> has no content: <done/>")
        return Action(kind)
    if not words:
        raise TagError(Reason.BAD_TARGET, f"<{kind}> names no target")
    if kind == "face":
        return Action(kind, _of(FACES, words, Reason.BAD_TARGET, "expression"))
    if kind in OF_OBJECTS:
        return Action(kind, _of(names, words, Reason.NOT_IN_VIEW, "object in view"))
    return Action(kind, _of([*names, *PLACES], words, Reason.NOT_IN_VIEW, "object or place"))


def _of(valid: Collection[str], words: str, reason: Reason, what: str) -> str:
    """The name that is meant: as spelt, else the only one that is the same but for case and _."""
    if words in valid:
        return words
    found = {name for name in valid if _plain(name) == _plain(words)}
    if len(found) == 1:
        return found.pop()
    listed = ", ".join(_show(name) for name in valid) or "none"
    raise TagError(reason, f"'{_show(words)}' is no {what}. There are: {listed[:200]}")


def _plain(name: str) -> str:
    return _one_line(re.sub(r"[_\-]", " ", name)).casefold()


def _one_line(text: str) -> str:
    """The text without control characters, blanks made single."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _near(reply: str, at: int) -> str:
    return _show(reply[at : at + 30])


def _show(text: str) -> str:
    """Foreign text for a message: one line, short, without brackets."""
    return _one_line(text)[:40].translate(str.maketrans("<>", "()"))
