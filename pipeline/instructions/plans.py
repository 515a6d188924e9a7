"""Action sequences that fulfil an instruction, and what an agent's plan is beside them.

A sequence is written as in ``suite.yaml``: ``grasp banana then point pear``, ``grasp ALL``,
``1-2 of grasp banana + grasp pear``, or one of ``ask``, ``refuse``, ``nothing``.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass

from pipeline.agent import Action, Turn
from pipeline.agent.action import KINDS, OF_OBJECTS
from pipeline.errors import PipelineError

WITHOUT_ACTION = ("ask", "refuse", "nothing")
CLASSES = (
    "right",
    "order",  # the right actions, in an order that is not
    "missing",  # some of the right ones and no other
    "too many",  # the right ones and others
    "wrong",  # others
    "asked",  # a question in place of actions
    "said so",  # words in place of actions
    "silent",  # neither actions nor words
    "no plan",  # a reply that cannot be used
)
_STEP = re.compile(r"(?:(?P<least>\d+)(?:-(?P<most>\d+))? of )?(?P<actions>[^+]+(?:\+[^+]+)*)")


class SuiteError(PipelineError):
    """A suite of instructions that is not what it should be."""


@dataclass(frozen=True)
class Step:
    """Actions in any order, and how many of them; each is a kind and a target."""

    actions: frozenset[str]
    least: int
    most: int


def read_plan(text: str, names: Collection[str]) -> list[Step]:
    """Return the steps of a sequence; none of one without actions.

    Args:
        text: As in the suite.
        names: Objects in view, for ``ALL``.

    Raises:
        SuiteError: It names an object that is not in view, or reads like no sequence.
    """
    if text in WITHOUT_ACTION:
        return []
    return [_step(part.strip(), names) for part in text.split(" then ")]


def _step(text: str, names: Collection[str]) -> Step:
    found = _STEP.fullmatch(text)
    if found is None:
        raise SuiteError(f"'{text}' must read like 'grasp banana + grasp pear' or '1-2 of ...'")
    actions: set[str] = set()
    for each in found["actions"].split("+"):
        kind, _, target = each.strip().partition(" ")
        targets = names if target == "ALL" else [target]
        if kind not in KINDS or not target:
            raise SuiteError(f"'{text}': an action is a kind and a target, got '{each.strip()}'")
        if kind in OF_OBJECTS and not set(targets) <= set(names):
            raise SuiteError(f"'{text}': {target} must be one of {sorted(names)}")
        actions |= {f"{kind} {name}" for name in targets}
    least = int(found["least"] or len(actions))
    return Step(frozenset(actions), least, int(found["most"] or least))


def done_of(turn: Turn) -> list[str]:
    """Return the actions of a turn but for words and the end, each as kind and target."""
    return [
        f"{each.kind} {each.target}" for each in turn.actions if each.kind not in ("speak", "done")
    ]


def fulfils(done: Sequence[str], steps: Sequence[Step]) -> bool:
    """Whether actions are those of the steps, in their order and no other."""
    if not steps:
        return not done
    step, *rest = steps
    for count in range(step.least, step.most + 1):
        now = done[:count]
        if len(set(now)) == count and set(now) <= step.actions and fulfils(done[count:], rest):
            return True
    return False


def classify(turn: Turn, right: Sequence[str], names: Collection[str]) -> str:
    """Return which of `CLASSES` a turn is.

    Args:
        turn: An agent's first reply.
        right: Sequences that fulfil the instruction, any of them.
        names: Objects in view.
    """
    if turn.problem:
        return "no plan"
    done, said = done_of(turn), _spoken(turn.actions)
    if not done:
        manner = "asked" if "?" in said else "said so" if said else "silent"
        wanted = {"ask": ("asked",), "refuse": ("said so",), "nothing": ("said so", "silent")}
        return "right" if any(manner in wanted.get(text, ()) for text in right) else manner
    plans = [read_plan(text, names) for text in right if text not in WITHOUT_ACTION]
    if any(fulfils(done, steps) for steps in plans):
        return "right"
    return min((_amiss(done, steps) for steps in plans), key=CLASSES.index, default="wrong")


def _amiss(done: Sequence[str], steps: Sequence[Step]) -> str:
    """How actions differ from the steps that they do not fulfil."""
    allowed = frozenset().union(*(step.actions for step in steps))
    together = all(len(set(done) & step.actions) >= step.least for step in steps)
    least, most = sum(step.least for step in steps), sum(step.most for step in steps)
    if set(done) <= allowed:
        if len(done) > most:
            return "too many"
        return "order" if together and len(done) >= least else "missing"
    return "too many" if together else "wrong"


def _spoken(actions: Sequence[Action]) -> str:
    return " ".join(each.text for each in actions if each.kind == "speak")
