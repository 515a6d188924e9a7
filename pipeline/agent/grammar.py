"""The grammar of instructions: its rules, with vocabulary and objects in view as terminals."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping
from functools import cached_property, lru_cache
from pathlib import Path

from lark import Lark, Token, Tree

from pipeline.agent.config import VocabularyConfig

RULES = Path(__file__).with_name("instruction.lark")
_WORD = re.compile(r"[a-z0-9]+|[,;:.?!]")
_MARKS = {";": ".", ":": ",", "?": ".", "!": "."}
_SHORT_FORMS = {
    r"\b(do|does|is|are)n'?t\b": r"\1 not",
    r"\b(won't|can't|cannot)\b": "can not",
    r"\b(i|you)'d\b": r"\1 would",
    r"\b(what|where|that|it)'s\b": r"\1 is",
    r"\byou're\b": "you are",
    r"\blet's\b": "let us",
}
_ADDRESS = r"(?:^|(?<=[.] ))[a-z0-9]+(?: [a-z0-9]+){0,2}(?= ,)"  # any robot's name, before a comma
_UP_TO_VERBS = r"[^.]+?(?=\s*(?:[.]|$)|(?:\s*(?:,|and\b|then\b))+\s*(?:{})\b)"


def phrase_of(name: str) -> str:
    """Return a name such as ``soup_can`` as words."""
    return " ".join(re.findall(r"[a-z0-9]+", name.lower()))


class Grammar:
    """The grammar for what is in view.

    Attributes:
        phrases: By terminal, each phrase and its meaning.
        words: All words of all phrases.
    """

    def __init__(self, vocabulary: VocabularyConfig, names: Iterable[str] = ()) -> None:
        """Give phrases to the terminals.

        Args:
            vocabulary: Phrases by what they mean.
            names: Labels of objects in view; those that the vocabulary knows are known anyhow.
        """
        self.phrases = _phrases(vocabulary, names)
        self.words = {
            word for listed in self.phrases.values() for p in listed for word in p.split()
        }
        self._verbs = {p.split()[0] for listed in vocabulary.verbs.values() for p in listed}

    def normalise(self, text: str) -> str:
        """Return lower-case words and marks with blanks between; short forms are written out."""
        text = text.lower().replace("’", "'")
        for short, full in _SHORT_FORMS.items():
            text = re.sub(short, full, text)
        return " ".join(_MARKS.get(word, self._stem(word)) for word in _WORD.findall(text))

    def parse(self, text: str) -> Tree[Token]:
        """Return the tree of a normalised text.

        Raises:
            lark.UnexpectedInput: It is not in the grammar.
        """
        return self.parser.parse(text, start="start")

    @cached_property
    def parser(self) -> Lark:
        """The parser; `phrases` are not to change after it was made."""
        return _parser(self._text())

    def meaning(self, token: Token) -> str:
        """Return what a token means: the key of the vocabulary that its phrase stands under."""
        text = " ".join(token.split())
        return self.phrases.get(token.type, {}).get(text, text)

    def unknown(self, text: str) -> list[str]:
        """Return the words of a normalised text that are in no phrase."""
        return [word for word in text.split() if word.isalnum() and word not in self.words]

    def _text(self) -> str:
        """The rules with all terminals."""
        beginning: dict[str, list[str]] = defaultdict(list)
        for phrase in {p for listed in self.phrases.values() for p in listed}:
            beginning[phrase.split()[0]].append(phrase)
        terminals = [f"{n}: /{_pattern(ps, beginning)}/" for n, ps in self.phrases.items()]
        word = f"(?!(?:{_alternatives(self.words)})\\b)[a-z0-9]+"
        terminals.append(f"UNKNOWN: /\\b{word}(?: (?:of )?{word})*\\b/")
        ends = [p for name in ("VERB", "LOOK", "FACE", "NOT") for p in self.phrases[name]]
        terminals.append(f"ADDRESS: /{_ADDRESS}/")
        terminals.append(f"SAID: /{_UP_TO_VERBS.format(_alternatives(ends))}/")
        return "\n".join([RULES.read_text(encoding="utf-8"), *terminals])

    def _stem(self, word: str) -> str:
        """The verb of a form in -ing: grasping, taking, grabbing."""
        stem = word.removesuffix("ing")
        forms = (stem, stem + "e", stem[:-1]) if stem != word else ()
        return next((verb for verb in forms if verb in self._verbs), word)


@lru_cache(maxsize=8)
def _parser(text: str) -> Lark:
    """Earley's, since a word may mean several things; made in half a second, hence kept."""
    return Lark(text, start=["start", "spoken"])


def _phrases(vocabulary: VocabularyConfig, names: Iterable[str]) -> dict[str, dict[str, str]]:
    """Phrases by terminal, with their meanings."""
    kinds = {"VERB": ("grasp", "push", "point"), "LOOK": ("look",), "EXPRESS": ("face",)}
    found = {
        terminal: _inverted({kind: vocabulary.verbs.get(kind, []) for kind in listed})
        for terminal, listed in (kinds | {"SPEAK": ("speak",)}).items()
    }
    for group in (
        "selectors",
        "relations",
        "orders",
        "numbers",
        "ordinals",
        "bounds",
        "faces",
        "places",
    ):
        found[group.upper().removesuffix("S")] = _inverted(getattr(vocabulary, group))
    found["GROUP"] = {word: word for word in vocabulary.groups}
    found["PROPERTY"] = {word: word for word in vocabulary.properties}
    for key, listed in vocabulary.words.items():
        found[key.upper()] = {phrase: phrase for phrase in listed}
    foreign = [name for name in names if name not in vocabulary.objects]
    heads = [phrase_of(name).rpartition(" ")[2] for name in foreign]
    short = {h: name for h, name in zip(heads, foreign, strict=True) if heads.count(h) == 1}
    known = _inverted({name: [phrase_of(name), *ps] for name, ps in vocabulary.objects.items()})
    nouns = short | known | {phrase_of(name): name for name in foreign}
    found["NAME"] = {phrase: name for phrase, name in nouns.items() if phrase}
    return found


def _inverted(meanings: Mapping[str, Iterable[str]]) -> dict[str, str]:
    return {phrase: key for key, listed in meanings.items() for phrase in listed}


def _alternatives(phrases: Iterable[str]) -> str:
    return "|".join(sorted(map(re.escape, phrases), key=len, reverse=True)) or "(?!)"


def _pattern(phrases: Iterable[str], beginning: Mapping[str, Iterable[str]]) -> str:
    """Any of the phrases as whole words, but where a longer phrase of any terminal begins."""
    parts = []
    for phrase in sorted(phrases, key=len, reverse=True):
        longer = (p for p in beginning[phrase.split()[0]] if p.startswith(phrase + " "))
        unless = _alternatives(each[len(phrase) :] for each in longer)
        parts.append(f"{re.escape(phrase)}\\b(?!(?:{unless})\\b)")
    return f"\\b(?:{'|'.join(parts) or '(?!)'})"
