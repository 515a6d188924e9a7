"""The sentences that speech is recognised with, as JSGF (Java Speech Grammar Format, W3C 2000).

It is written from the part `spoken` of the agent's grammar, so that what is recognised has a
meaning. Phrases share their first words: the decoder is tens of times slower where they do not.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping

from lark import UnexpectedInput

from pipeline.agent.config import VocabularyConfig
from pipeline.agent.grammar import Grammar

START = "spoken"
Rest = tuple[str, ...]  # what may still be said: words, and names in angle brackets


class SpokenGrammar(Grammar):
    """The grammar of instructions with a scene's names and the words that a recogniser knows."""

    def __init__(
        self,
        vocabulary: VocabularyConfig,
        names: Iterable[str],
        robots: Iterable[str] = (),
        known: Callable[[str], bool] = lambda word: True,
    ) -> None:
        """Choose phrases.

        Args:
            vocabulary: Phrases by what they mean.
            names: Objects that may be in view.
            robots: Names that the robot may be called by.
            known: Whether the recogniser's dictionary has a word; phrases with others are left out.
        """
        names = set(names)
        super().__init__(vocabulary, names)
        self.phrases["COURTESY"] |= {name: name for name in robots}
        there = {word for word, members in vocabulary.groups.items() if names & set(members)}
        for terminal, present in (("NAME", names), ("GROUP", there)):
            listed = self.phrases[terminal].items()
            self.phrases[terminal] = {phrase: name for phrase, name in listed if name in present}
        for terminal, phrases in self.phrases.items():
            kept = {p: m for p, m in phrases.items() if all(map(known, p.split()))}
            self.phrases[terminal] = kept

    def accepts(self, sentence: str) -> bool:
        """Whether a sentence is in the grammar."""
        try:
            return bool(self.parser.parse(sentence.lower(), start=START))
        except UnexpectedInput:
            return False

    def jsgf(self) -> str:
        """Return the grammar in the format of recognisers."""
        rules = self._rules()
        lines, wanted = ["#JSGF V1.0;", "grammar instruction;"], [START]
        for name in wanted:  # it grows
            body = _shared(rules[name], f"<{name}>")
            lines.append(f"{'public ' * (name == START)}<{name}> = {body};")
            named = (each.strip("<>") for rest in rules[name] for each in rest if each[0] == "<")
            wanted += [each for each in dict.fromkeys(named) if each not in wanted]
        return "\n".join(lines)

    def arcs(self) -> list[tuple[int, int, float, str | None]]:
        """Return the grammar without choices between equal words: from, to, probability, word.

        A decoder searches the words of a state as one tree, and those of several states one by one;
        so a state here is all that may follow (the subset construction of Rabin and Scott, 1959).
        It begins in state 0 and ends in state 1; the words of a state are as likely.
        """
        rules = self._rules()
        states: dict[frozenset[Rest], int] = {_words_next(rules, {(f"<{START}>",)}): 0}
        found: list[tuple[int, int, float, str | None]] = []
        for state, number in (pending := list(states.items())):  # which grows
            after: dict[str, set[Rest]] = defaultdict(set)
            for first, *rest in filter(None, state):
                after[first].add(tuple(rest))
            ends = () in state
            chance = 1.0 / max(len(after) + ends, 1)
            for word, rests in sorted(after.items()):
                following = _words_next(rules, rests)
                if following not in states:
                    states[following] = len(states) + 1
                    pending.append((following, states[following]))
                found.append((number, states[following], chance, word))
            found += [(number, 1, chance, None)] * ends
        return found

    def _rules(self) -> dict[str, list[list[str]]]:
        """Alternatives by name: names in angle brackets, and words."""
        rules: dict[str, list[list[str]]] = defaultdict(list)
        for rule in self.parser.rules:
            rules[rule.origin.name].append([f"<{each.name}>" for each in rule.expansion])
        named = {name: [phrase.split() for phrase in ps] for name, ps in self.phrases.items()}
        return rules | named


def _shared(sequences: Iterable[list[str]], itself: str) -> str:
    """Sequences as one expression in which those that begin alike are one; `itself X` repeats X."""
    following: dict[str, list[list[str]]] = defaultdict(list)
    rests = list(sequences)
    for first, *rest in filter(None, rests):
        following[first].append(rest)
    repeated = following.pop(itself, None)
    parts = [" ".join(filter(None, (f, _shared(rs, "")))) for f, rs in following.items()]
    if not parts:
        return "" if rests else "<VOID>"
    whole = f"({' | '.join(parts)})"
    return f"{whole}+" if repeated else whole if all(rests) else f"[{whole}]"


def _words_next(rules: Mapping[str, list[list[str]]], rests: set[Rest]) -> frozenset[Rest]:
    """What may follow, each with a word in front; nothing where a sentence may end."""
    found, pending = set(), list(rests)
    for rest in pending:  # which grows
        if not rest or rest[0][0] != "<":
            found.add(rest)
            continue
        name = rest[0].strip("<>")
        repeated = any(each[:1] == [rest[0]] for each in rules[name])
        for each in rules[name]:
            if each[:1] != [rest[0]]:
                pending.append((*each, *rest[1:]))
                pending += [(*each, *rest)] * repeated
    return frozenset(found)
