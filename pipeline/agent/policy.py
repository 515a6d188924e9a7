"""The embedded policy: a grammar of instructions. No network, no randomness.

It is a language model like any other: it reads the scene from the text of the user turn, and its
replies are checked like any other's. Where any part of an instruction is not understood or not
clear it does none of it, and says so.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from lark.exceptions import UnexpectedInput, VisitError

from pipeline.agent.action import Action
from pipeline.agent.config import VocabularyConfig
from pipeline.agent.grammar import Grammar, phrase_of
from pipeline.agent.model import Message
from pipeline.agent.scene_text import GO_ON, SILENCE, read_user_text
from pipeline.agent.understanding import Intent, Reader, UnclearError

DONE = Action("done").as_tag()
NOT_UNDERSTOOD = (
    "I do not understand. Ask me to grasp, push, point at or look at something in view."
)
CONDITION = "I do not follow conditions. Tell me what to do, in the order of the actions."
_PHRASES = {"grasp": "I grasp the {}. ", "push": "I push the {}. ", "point": "There is the {}. "}
_TARGET = re.compile(r"<(?:grasp|push|point|look)>([^<>]+)</")


class Policy:
    """Understands plain requests and says so where it does not.

    Attributes:
        name: Its name in rows and transcripts.
    """

    name = "policy"

    def __init__(self, vocabulary: VocabularyConfig) -> None:
        """Take the words it knows."""
        self._vocabulary = vocabulary
        self._members = {"GROUP": vocabulary.groups, "PROPERTY": vocabulary.properties}

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer the last user turn; see `pipeline.agent.model.LanguageModel`."""
        instruction, seen = read_user_text(messages[-1].content)
        if instruction in (GO_ON, SILENCE):
            return DONE
        grammar = Grammar(self._vocabulary, [each.name for each in seen])
        text = grammar.normalise(instruction)
        reader = Reader(grammar, self._members, seen, _spoken_of(messages[:-1]))
        try:
            intents = reader.transform(grammar.parse(text))
        except UnexpectedInput:
            return f"{self._puzzled(grammar, text)} {DONE}"
        except VisitError as error:
            if not isinstance(error.orig_exc, UnclearError):
                raise
            return f"{error.orig_exc} {DONE}"
        return _composed(intents, reader.remarks)

    def _puzzled(self, grammar: Grammar, text: str) -> str:
        """What to say of an instruction that is not in the grammar."""
        if any(f" {each} " in f" {text} " for each in self._vocabulary.words["condition"]):
            return CONDITION
        unknown = " or ".join(f"'{word}'" for word in dict.fromkeys(grammar.unknown(text)))
        return f"I do not know the word {unknown}. {NOT_UNDERSTOOD}" if unknown else NOT_UNDERSTOOD


def _composed(intents: Sequence[Intent], remarks: Sequence[str]) -> str:
    parts = list(dict.fromkeys(remarks))
    floating = [each.target for each in intents if not (each.kind or each.spared)]
    parts += [_act(each) for each in intents if each.kind and not each.spared]
    if floating and len(floating) == len(intents):
        look = Action("look", floating[0]).as_tag()
        parts.append(f"What shall I do with the {phrase_of(floating[0])}? {look}")
    spared = dict.fromkeys(phrase_of(each.target) for each in intents if each.spared)
    if spared:
        parts.append(f"I leave {' and '.join(f'the {name}' for name in spared)}.")
    return " ".join([*(parts or [NOT_UNDERSTOOD]), DONE])


def _act(intent: Intent) -> str:
    if intent.kind == "speak":
        return Action("speak", text=intent.target).as_tag()
    words = _PHRASES.get(intent.kind, "").format(phrase_of(intent.target))
    return words + Action(intent.kind, intent.target).as_tag()


def _spoken_of(messages: Sequence[Message]) -> str | None:
    """The last target of an earlier reply, which "it" may mean."""
    for message in reversed(messages):
        if message.role == "assistant" and (found := _TARGET.findall(message.content)):
            return str(found[-1])
    return None
