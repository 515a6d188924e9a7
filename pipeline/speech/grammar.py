"""The sentences that speech is recognised with: a graph of words from the agent's vocabulary.

It holds what the embedded policy understands, so that what is recognised has a meaning. Phrases
that leave the same state share their first words: the decoder searches each state's words as one
tree, and a grammar written as alternatives, which shares nothing, is tens of times slower.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass

from pipeline.agent.config import VocabularyConfig
from pipeline.agent.lexicon import phrase_of

_VERBS = ("grasp", "push", "point", "look")  # what follows speak is in no grammar
_FACES = ("smile", "laugh", "make a happy face", "make a sad face", "be happy", "be sad")
_POLITE = ("please", "could you", "could you please", "can you", "can you please", "would you")
_NEGATIONS = ("do not", "don't", "never")
_JOINTS = ("and", "then", "and then", "after that")
_EXTRAS = ("on the table", "into the bin", "one after another", "please", "now")
_ROW = "choose the order of the objects yourself"
_QUESTIONS = ("what do you see", "what can you do", "stop", "hello")
_THINGS = ("object", "thing", "one")
# States; those of the phrases' inner words come after them.
START, CLAUSE, VERB, TARGET, NOUN, WHICH, PLACE, MANY, ENDED, FINAL = range(10)
EPSILON = ""


@dataclass(frozen=True)
class Arc:
    """A transition from a state to a state; without a word it is free."""

    source: int
    target: int
    word: str


class Graph:
    """A finite-state grammar from `START` to `FINAL`.

    Attributes:
        arcs: Its transitions.
    """

    def __init__(self, known: Callable[[str], bool]) -> None:
        """Begin without arcs.

        Args:
            known: Whether the recogniser's dictionary has a word; phrases with others are left out.
        """
        self.arcs: list[Arc] = []
        self._known = known
        self._inner: dict[tuple[int, str], int] = {}
        self._present: set[Arc] = set()

    @property
    def states(self) -> int:
        """Number of states."""
        return FINAL + 1 + len(self._inner)

    def add(self, source: int, target: int, phrases: Iterable[str]) -> None:
        """Let phrases lead from a state to a state."""
        for phrase in phrases:
            words = phrase.lower().split()
            if not words or not all(map(self._known, words)):
                continue
            at = source
            for word in words[:-1]:
                after = self._inner.setdefault((at, word), FINAL + 1 + len(self._inner))
                self._arc(at, after, word)
                at = after
            self._arc(at, target, words[-1])

    def free(self, source: int, target: int) -> None:
        """Let a state lead to another without a word."""
        self._arc(source, target, EPSILON)

    def weighted(self) -> list[tuple[int, int, float, str | None]]:
        """Return (from, to, probability, word) of each arc; the words of a state are as likely."""
        leaving = [0] * self.states
        for arc in self.arcs:
            leaving[arc.source] += 1
        return [
            (arc.source, arc.target, 1.0 / leaving[arc.source], arc.word or None)
            for arc in self.arcs
        ]

    def accepts(self, sentence: str) -> bool:
        """Whether a sentence is in the grammar."""
        states = self._closure({START})
        for word in sentence.lower().split():
            states = self._closure(
                {arc.target for arc in self.arcs if arc.source in states and arc.word == word}
            )
        return FINAL in states

    def _closure(self, states: set[int]) -> set[int]:
        found = set(states)
        while True:
            more = {a.target for a in self.arcs if a.source in found and a.word == EPSILON} - found
            if not more:
                return found
            found |= more

    def _arc(self, source: int, target: int, word: str) -> None:
        arc = Arc(source, target, word)
        if arc not in self._present:
            self._present.add(arc)
            self.arcs.append(arc)


def instruction_graph(
    vocabulary: VocabularyConfig,
    names: Iterable[str],
    robots: Iterable[str] = (),
    known: Callable[[str], bool] = lambda word: True,
) -> Graph:
    """Return the grammar of instructions.

    Args:
        vocabulary: Phrases by what they mean.
        names: Objects that may be in view.
        robots: Names that the robot may be called by.
        known: Whether the recogniser's dictionary has a word.
    """
    objects = list(names)
    graph = Graph(known)
    graph.add(START, CLAUSE, [*_POLITE, *robots, *(f"{name} please" for name in robots)])
    graph.add(START, FINAL, _QUESTIONS)
    graph.add(START, NOUN, ["where is the"])
    graph.free(START, CLAUSE)
    graph.add(CLAUSE, VERB, _NEGATIONS)
    graph.free(CLAUSE, VERB)
    for kind in _VERBS:
        graph.add(VERB, TARGET, vocabulary.verbs.get(kind, ()))
    graph.add(VERB, PLACE, vocabulary.verbs.get("look", ()))
    graph.add(VERB, ENDED, [*vocabulary.clearing, *_FACES])
    _add_targets(graph, vocabulary, objects)
    graph.add(ENDED, ENDED, _EXTRAS)
    graph.add(ENDED, CLAUSE, _JOINTS)
    graph.add(ENDED, TARGET, ["and"])
    graph.add(ENDED, FINAL, [_ROW])
    graph.free(ENDED, FINAL)
    return graph


def _add_targets(graph: Graph, vocabulary: VocabularyConfig, names: Collection[str]) -> None:
    sides = [phrase for phrases in vocabulary.selectors.values() for phrase in phrases]
    graph.add(TARGET, NOUN, ["a", "an"])
    graph.add(TARGET, WHICH, ["the"])
    graph.add(TARGET, ENDED, ["it"])
    graph.add(TARGET, MANY, [*vocabulary.everything, *_groups(vocabulary, names)])
    for state in (TARGET, NOUN, WHICH):
        graph.add(state, ENDED, _nouns(vocabulary, names))
    for side in sides:
        if len(side.split()) == 1:
            graph.add(WHICH, ENDED, [f"{side} {kind}" for kind in _THINGS])
        elif side.split()[0] in ("on", "in"):
            graph.add(WHICH, ENDED, [f"{kind} {side}" for kind in _THINGS])
    graph.free(MANY, ENDED)
    graph.add(MANY, TARGET, vocabulary.exceptions)
    graph.add(PLACE, ENDED, (p for phrases in vocabulary.places.values() for p in phrases))


def _nouns(vocabulary: VocabularyConfig, names: Collection[str]) -> list[str]:
    nouns = [phrase_of(name) for name in names]
    for name in names:
        nouns += vocabulary.objects.get(name, [])
    return nouns


def _groups(vocabulary: VocabularyConfig, names: Collection[str]) -> list[str]:
    present = [word for word, members in vocabulary.groups.items() if set(members) & set(names)]
    return [f"{before}{word}" for word in present for before in ("all the ", "the ")]
