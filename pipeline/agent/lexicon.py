"""Words to meanings: an instruction as tokens, each the longest phrase that the vocabulary has."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from pipeline.agent.config import VocabularyConfig

PAUSE, STOP = ",", "."
_WORD = re.compile(r"[a-z0-9]+|[,;:]|[.?!]")
_SHORT_FORMS = {
    "don't": "do not",
    "dont": "do not",
    "doesn't": "does not",
    "won't": "will not",
    "can't": "can not",
    "cannot": "can not",
    "i'd": "i would",
    "let's": "let us",
    "what's": "what is",
    "where's": "where is",
    "that's": "that is",
    "it's": "it is",
}


@dataclass(frozen=True)
class Token:
    """A phrase of an instruction.

    Attributes:
        text: The words.
        meanings: What they may mean: "verb", "object", "place", ... to the value.
    """

    text: str
    meanings: Mapping[str, str]

    def value(self, kind: str) -> str | None:
        """Return what the token means as a ``kind``, or None."""
        return self.meanings.get(kind)


def normalise(text: str) -> str:
    """Return lower-case words and punctuation, short forms written out."""
    text = text.lower().replace("’", "'")
    for short, full in _SHORT_FORMS.items():
        text = re.sub(rf"\b{short}\b", full, text)
    return text


def phrase_of(name: str) -> str:
    """Return a name such as ``soup_can`` as words."""
    return " ".join(re.findall(r"[a-z0-9]+", name.lower()))


class Lexicon:
    """The vocabulary, with the objects in view added.

    Attributes:
        names: Labels of the objects in view.
    """

    def __init__(self, vocabulary: VocabularyConfig, names: Iterable[str]) -> None:
        """Index the phrases.

        Args:
            vocabulary: Phrases by what they mean.
            names: Labels of the objects in view.
        """
        self.names = tuple(names)
        self._meanings: dict[tuple[str, ...], dict[str, str]] = {}
        self._verbs: set[str] = set()
        self._add_lists(vocabulary)
        self._add_objects(vocabulary)
        self._longest = max(len(words) for words in self._meanings)

    def tokens(self, text: str) -> list[Token]:
        """Return the tokens of an instruction, unknown words and punctuation among them."""
        words = [self._stem(word) for word in _WORD.findall(normalise(text))]
        return list(self._match(words))

    def _match(self, words: Sequence[str]) -> Iterator[Token]:
        at = 0
        while at < len(words):
            for length in range(min(self._longest, len(words) - at), 0, -1):
                phrase = tuple(words[at : at + length])
                if phrase in self._meanings:
                    yield Token(" ".join(phrase), self._meanings[phrase])
                    at += length
                    break
            else:
                word = words[at]
                mark = PAUSE if word in ",;:" else STOP if word in ".?!" else ""
                yield Token(word, {"mark": mark} if mark else {})
                at += 1

    def _stem(self, word: str) -> str:
        """The verb of a form in -ing: grasping, taking, grabbing."""
        if word.endswith("ing"):
            stem = word[:-3]
            for verb in (stem, stem + "e", stem[:-1]):
                if verb in self._verbs:
                    return verb
        return word

    def _add(self, phrase: str, kind: str, value: str) -> None:
        words = tuple(phrase.split())
        if words:
            self._meanings.setdefault(words, {}).setdefault(kind, value)

    def _add_lists(self, vocabulary: VocabularyConfig) -> None:
        kinds = (
            ("verb", vocabulary.verbs),
            ("selector", vocabulary.selectors),
            ("order", vocabulary.orders),
            ("face", vocabulary.faces),
            ("place", vocabulary.places),
        )
        for kind, phrases in kinds:
            for value, listed in phrases.items():
                for phrase in listed:
                    self._add(phrase, kind, value)
        self._verbs = {p.split()[0] for listed in vocabulary.verbs.values() for p in listed}
        for kind in (
            *("everything", "clearing", "pronouns", "negations", "exceptions", "sequence"),
            *("beginnings", "relations", "conditions", "politeness", "idle"),
        ):
            for phrase in getattr(vocabulary, kind):
                self._add(phrase, kind, phrase)
        for value in vocabulary.groups:
            for before in ("", "all ", "all the ", "all of the ", "every ", "each ", "the "):
                self._add(before + value, "group", value)

    def _add_objects(self, vocabulary: VocabularyConfig) -> None:
        """Names in view first: what is seen has precedence over what is only known."""
        for name in self.names:
            self._add(phrase_of(name), "object", name)
        for name in self.names:
            for phrase in vocabulary.objects.get(name, ()):
                self._add(phrase, "object", name)
        heads = [phrase_of(name).rpartition(" ") for name in self.names]
        for name, (rest, _, head) in zip(self.names, heads, strict=True):
            alone = sum(other[2] == head for other in heads) == 1
            if rest and alone and (head,) not in self._meanings:
                self._add(head, "object", name)
        for known, phrases in vocabulary.objects.items():
            for phrase in (phrase_of(known), *phrases):
                if "object" not in self._meanings.get(tuple(phrase.split()), {}):
                    self._add(phrase, "absent", phrase_of(known))


def is_noun(token: Token) -> bool:
    """Whether a token names an object, in view or not."""
    return "object" in token.meanings or "absent" in token.meanings


def token_at(tokens: Sequence[Token], index: int) -> Token:
    """Return a token, or one without words and meaning beyond the end."""
    return tokens[index] if index < len(tokens) else Token("", {})
