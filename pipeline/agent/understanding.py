"""From the tree of an instruction to its meaning: what to do with which object, in order."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

from lark import Token, Transformer

from pipeline.agent.grammar import Grammar, phrase_of
from pipeline.agent.places import (
    ORDERS,
    RELATIONS,
    SELECTORS,
    SIDES,
    Measure,
    distance,
    is_between,
    middle,
)
from pipeline.agent.scene_text import Seen

Members = Mapping[str, Mapping[str, Sequence[str]]]
_CLEARLY = 1.2  # times as far as the nearest neighbour: what is nearer is a neighbour as well
_NOTHING = "I see nothing of that kind."
_REMARKS = {  # by the grammar's rule
    "able": "I can grasp, push, point at and look at what is in view, and show how I feel.",
    "enough": "All right.",
    "greeting": "Hello, what shall I do?",
    "misplace": "I do not know places beside other objects.",
}
_RANKS = {"FIRST": -1, "STARTING": -1, "LAST": 1, "ENDING": 1}


class UnclearError(Exception):
    """What is meant is not clear; the message is the question to ask back."""


@dataclass(frozen=True)
class Intent:
    """An action and its target, or one that is spared; of speak the words.

    Without a kind it is that of the one before; of a spared one it is any.
    """

    kind: str
    target: str
    spared: bool = False


class _Choice(NamedTuple):
    """What an object must be; of those that are, the one with the least measure is meant."""

    keep: Callable[[Seen], bool]
    measure: Measure = lambda each: 0.0
    clearly: float = 0.0  # times the least measure that the next one must have; 0 = nothing is told


class Reader(Transformer[Token, Any]):
    """Reads a tree from left to right: "it" is what was named last.

    Attributes:
        remarks: What to say: answers, and what cannot be done.
    """

    def __init__(
        self, grammar: Grammar, members: Members, seen: Sequence[Seen], last: str | None
    ) -> None:
        """Take what words mean, which objects a GROUP or PROPERTY has, and what is in view."""
        super().__init__()
        self._meaning, self._members, self._nouns = (
            grammar.meaning,
            members,
            grammar.phrases["NAME"],
        )
        self._seen = {each.name: each for each in sorted(seen, key=ORDERS["right_to_left"])}
        self._last = [last] if last in self._seen else []
        self._named: set[str] = set()
        self.remarks: list[str] = []

    def np(self, parts: list[Any]) -> list[str]:
        """Return the names that a noun phrase means; none, and a remark, if nothing is so."""
        words = {each.type: self._meaning(each) for each in parts if isinstance(each, Token)}
        if "PRONOUN" in words:
            return self._referred(words["PRONOUN"])
        name = words.get("UNKNOWN", words.get("NAME"))
        if name and name not in self._seen:
            return self._remark(f"I do not see {article(phrase_of(name))}.")
        placed = "SELECTOR" in words or any(isinstance(each, _Choice) for each in parts)
        many = _is_many(words, placed)
        parts = [each for each in parts if not name or self._is_colour(each)]
        choices = list(self._choices(parts, many))
        fit = [each for each in self._seen.values() if not name or each.name == name]
        fit = [each for each in fit if "REST" not in words or each.name not in self._named]
        for keep, measure, _ in choices:
            fit = sorted(filter(keep, fit), key=measure)
        if not fit:
            return self._remark(_NOTHING)
        told = len(fit) < 2 or any(c.clearly and _is_told(fit, c) for c in choices)
        names = [each.name for each in fit]
        self._last = names if many else self._counted(words, names, told)
        self._named |= set(self._last)
        return self._last

    def ref(self, parts: list[Any]) -> Seen | None:
        """Return the object that others are placed by; None if it is not in view."""
        names = self.np(parts)
        return self._seen[names[0]] if names else None

    def relation(self, parts: list[Any]) -> _Choice:
        """Return the choice of a place by another object."""
        name, anchor = self._meaning(parts[0]), parts[1]
        if anchor is None:
            return _Choice(lambda each: False)
        return _Choice(
            lambda each: each != anchor and RELATIONS[name](each, anchor),
            lambda each: distance(each, anchor),
            _CLEARLY if name == "next_to" else 1.0,
        )

    def between(self, parts: list[Any]) -> _Choice:
        """Return the choice of what lies between two objects."""
        one, other = (each for each in parts if not isinstance(each, Token))
        return _Choice(lambda each: bool(one and other) and is_between(each, one, other))

    def unlike(self, parts: list[Any]) -> _Choice:
        """Return the choice of what is not so."""
        (alike,) = self._choices(parts, many=True)
        return _Choice(lambda each: not alike.keep(each))

    def _choices(self, parts: Sequence[Any], many: bool) -> Iterator[_Choice]:
        for each in parts:
            if isinstance(each, _Choice):
                yield each
            elif each.type in ("GROUP", "PROPERTY", "NAME"):
                word = self._meaning(each)
                members = self._members.get(each.type, {}).get(word, [word])
                yield _Choice(partial(_is_of, members))
            elif each.type == "SELECTOR" and many and (side := SIDES.get(self._meaning(each))):
                yield _Choice(partial(_is_at, side))
            elif each.type == "SELECTOR":
                measure = SELECTORS.get(self._meaning(each)) or middle(list(self._seen.values()))
                yield _Choice(lambda seen: True, measure, 1.0)

    def _is_colour(self, part: Any) -> bool:
        """Whether an object of that name must be so; not where the word is a noun: orange ball."""
        return getattr(part, "type", "") == "PROPERTY" and part not in self._nouns

    def _referred(self, word: str) -> list[str]:
        if not self._last:
            raise UnclearError("I do not know which object you mean. Which one is it?")
        return self._last if word in ("them", "those", "these") else self._last[-1:]

    def _counted(self, words: Mapping[str, str], names: list[str], told: bool) -> list[str]:
        number, bound = int(words.get("NUMBER", 1)), words.get("BOUND")
        if "NUMBER" in words and bound != "at_most" and len(names) < number:
            return self._remark(f"I see only {len(names)} of that kind.")
        first = int(words.get("ORDINAL", 1)) - 1
        if len(names) > 1 and not (told or {"NUMBER", "A", "BOUND"} & set(words)):
            raise UnclearError(_which(names))
        return names[first : first + number]

    def _remark(self, words: str) -> list[str]:
        self.remarks.append(words)
        return []

    # In which order, and what is to be done with them.

    def nps(self, parts: list[Any]) -> list[str]:
        """Return the names of a list: what is said to come first, the others, what comes last."""
        ranked: list[tuple[int, list[str]]] = []
        for each in parts:
            if isinstance(each, list):
                ranked.append((0, each))
            elif each.type in _RANKS:
                ranked[-1] = (_RANKS[each.type], ranked[-1][1])
        return [name for _, names in sorted(ranked, key=lambda part: part[0]) for name in names]

    def either(self, parts: list[Any]) -> list[str]:
        """Ask which of several."""
        raise UnclearError(_which(_flat(parts)))

    def backwards(self, parts: list[Any]) -> list[Any]:
        """Return first what the other comes after."""
        return _flat(parts[::-1])

    def changed(self, parts: list[Any]) -> Callable[[list[str]], list[str]]:
        """Return what sorts names, or leaves some out."""
        named = _flat(parts)
        if parts[0].type == "ORDER":
            measure = ORDERS[self._meaning(parts[0])]
            return lambda names: sorted(names, key=lambda name: measure(self._seen[name]))
        if parts[0].type in _RANKS:
            rank = _RANKS[parts[0].type]
            return lambda names: sorted(names, key=lambda name: rank * (name in named))
        return lambda names: [name for name in names if name not in named]

    def act(self, parts: list[Any]) -> list[Intent]:
        """Return the intents of a verb; one without a target if there is no such object."""
        names = _flat(parts)
        for each in parts:
            names = each(names) if callable(each) else names
        return [Intent(self._kind(parts), name) for name in names or [""]]

    more = act

    def clear(self, parts: list[Any]) -> list[Intent]:
        """Return grasps of all that is in view."""
        everything = list(self._seen) or self._remark(_NOTHING)
        return self.act([Token("PUT", ""), everything, *parts])

    def bare(self, parts: list[Any]) -> list[Intent]:
        """Ask for what a verb lacks."""
        kind = self._kind(parts)
        raise UnclearError(f"What shall I {kind}{' at' if kind in ('point', 'look') else ''}?")

    def spare(self, parts: list[Any]) -> list[Intent]:
        """Return what is not to be done."""
        return [replace(intent, spared=True) for intent in self.act(parts)]

    def in_order(self, parts: list[Any]) -> list[Intent]:
        """Return the intents of two clauses; names alone are of the other clause's kind."""
        said = _flat(parts)
        kind = next(each.kind for each in said if isinstance(each, Intent))
        return [each if isinstance(each, Intent) else Intent(kind, each) for each in said]

    def reversed(self, parts: list[Any]) -> list[Intent]:
        """Return the intents of two clauses, those of the later one first."""
        return self.in_order(parts[::-1])

    def plain(self, parts: list[Token]) -> list[Intent]:
        """Return a look at a place, an expression, or words to say."""
        kinds = {"PLACE": "look", "FACE": "face", "SAID": "speak"}
        intents = [Intent(kinds[e.type], self._meaning(e)) for e in parts if e.type in kinds]
        if any(i.kind == "speak" and not any(map(str.isalnum, i.target)) for i in intents):
            raise UnclearError("What shall I say?")
        return intents

    def _kind(self, parts: list[Any]) -> str:
        """The kind of a clause's verb: none without a verb, and of one that is no action."""
        found = [each for each in parts if getattr(each, "type", "") in ("VERB", "LOOK", "PUT")]
        return ("grasp" if found[0].type == "PUT" else self._meaning(found[0])) if found else ""

    # What is asked, and all together.

    def whereabouts(self, parts: list[Any]) -> list[Intent]:
        """Say where objects are, and look at them."""
        for name in parts[1]:
            side = self._seen[name].side
            where = "in the middle" if side == "middle" else f"on the {side}"
            self._remark(f"I see the {phrase_of(name)} {where}.")
        return [Intent("look", name) for name in parts[1]]

    def listing(self, parts: list[Token]) -> list[str]:
        """Say what is in view."""
        group = next((self._members["GROUP"][e] for e in parts if e.type == "GROUP"), self._seen)
        names = [article(phrase_of(name)) for name in reversed(self._seen) if name in group]
        return self._remark(f"I see {_listed(names, 'and')}." if names else _NOTHING)

    def __default__(self, data: object, parts: list[Any], meta: Any) -> list[str]:
        """Answer what is neither a question of the scene nor an action."""
        return self._remark(_REMARKS[str(data)])

    def start(self, parts: list[Any]) -> list[Intent]:
        """Return all intents: with their kinds, without what is spared, no grasp twice."""
        found: list[Intent] = []
        for intent in _flat(parts):
            kind = intent.kind or (found[-1].kind if found and not intent.spared else "")
            if kind != "grasp" or Intent(kind, intent.target) not in found:
                found.append(replace(intent, kind=kind))
        spared = {(each.kind, each.target) for each in found if each.spared}
        free = [e for e in found if not {("", e.target), (e.kind, e.target)} & spared]
        return [each for each in [*free, *(e for e in found if e.spared)] if each.target]


def article(words: str) -> str:
    """Return words with the indefinite article."""
    return f"{'an' if words[:1] in 'aeiou' else 'a'} {words}"


def _is_of(members: Sequence[str], seen: Seen) -> bool:
    return seen.name in members


def _is_at(side: str, seen: Seen) -> bool:
    return seen.side == side


def _flat(parts: Sequence[Any]) -> list[Any]:
    """What the lists among parts hold."""
    return [each for part in parts if isinstance(part, list) for each in part]


def _listed(words: Sequence[str], word: str) -> str:
    return f" {word} ".join(filter(None, (", ".join(words[:-1]), words[-1])))


def _which(names: Sequence[str]) -> str:
    return f"Which one: {_listed([f'the {phrase_of(name)}' for name in names], 'or')}?"


def _is_told(fit: Sequence[Seen], choice: _Choice) -> bool:
    """Whether a measure tells the first of what fits from the one after it."""
    return choice.measure(fit[1]) >= choice.clearly * choice.measure(fit[0])


def _is_many(words: Mapping[str, str], placed: bool) -> bool:
    """Whether several objects are meant; one kind of fruit may be, unless a place tells one."""
    if {"ALL", "EVERYTHING", "REST"} & set(words):
        return True
    if {"NUMBER", "ORDINAL", "A", "NAME", "THING"} & set(words):
        return False
    group = words.get("GROUP", "")
    return "THINGS" in words or group.endswith("s") or bool(group and not placed)
