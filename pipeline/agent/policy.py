"""The embedded policy: fixed rules that speak the tag language. No network, no randomness.

It is a language model like any other: it reads the scene from the text of the user turn, and its
replies are checked like any other's.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from pipeline.agent.action import Action
from pipeline.agent.config import VocabularyConfig
from pipeline.agent.intents import Intent, Understanding, article, as_words
from pipeline.agent.lexicon import Lexicon, Token, normalise
from pipeline.agent.model import Message
from pipeline.agent.scene_text import GO_ON, SILENCE, Seen, read_user_text
from pipeline.agent.understanding import Reader

DONE = Action("done").as_tag()
NOT_UNDERSTOOD = (
    "I do not understand. Ask me to grasp, push, point at or look at something in view."
)
CONDITION = "I do not follow conditions. Tell me what to do, in the order of the actions."
_ABLE = "I can grasp, push, point at and look at what is in view, and show how I feel."
_PHRASES = {
    "grasp": "I grasp the {}.",
    "push": "I push the {}.",
    "point": "There is the {}.",
    "look": "",
    "face": "",
    "speak": "",
}
_QUESTION = re.compile(
    r"^(?:(?:please|hey|hello|now|and|so|robot|nicol?|tell me) )*"
    r"(?P<word>what|which|where|who|how many|is there|are there|(?:do|can) you see|describe|list)\b"
)
_ABLE_QUESTION = re.compile(r"\b(?:who are you|what can you do|what are you|can you do)\b")
_ENOUGH = re.compile(r"^(?:please |ok |okay )*(?:stop|nothing|that is all|no thanks|no)\b")
_GREETING = re.compile(r"^(?:hello|hi|hey|good (?:morning|evening|afternoon))\b")
_TARGET = re.compile(r"<(?:grasp|push|point|look)>([^<>]+)</")


class Policy:
    """Understands plain requests and says so where it does not.

    Attributes:
        name: Its name in rows and transcripts.
    """

    name = "policy"

    def __init__(self, vocabulary: VocabularyConfig) -> None:
        """Take the words it knows.

        Args:
            vocabulary: Phrases by what they mean.
        """
        self._vocabulary = vocabulary

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer the last user turn; see `pipeline.agent.model.LanguageModel`."""
        instruction, seen = read_user_text(messages[-1].content)
        if instruction in (GO_ON, SILENCE):
            return DONE
        lexicon = Lexicon(self._vocabulary, [each.name for each in seen])
        text = normalise(instruction)
        if _ENOUGH.match(text):
            return f"All right. {DONE}"
        last, groups = _spoken_of(messages[:-1]), self._vocabulary.groups
        commands: list[str] = []
        answers: list[str] = []
        for sentence in re.split(r"(?<=[.?!])\s+", text):
            if _QUESTION.match(sentence) or _ABLE_QUESTION.search(sentence):
                answer, last = _answer(sentence, lexicon.tokens(sentence), seen, groups, last)
                answers.append(answer)
            else:
                commands.append(sentence)
        tokens = lexicon.tokens(" ".join(commands))
        if any("conditions" in token.meanings for token in tokens):
            return f"{CONDITION} {DONE}"
        found = Reader(lexicon, seen, groups, last).read(tokens)
        if not (found.intents or found.remarks) and any("negations" in t.meanings for t in tokens):
            answers.append("All right.")
        found.spared = [name for name in dict.fromkeys(found.spared) if name in lexicon.names]
        return _compose(found, answers, text)


def _compose(found: Understanding, answers: Sequence[str], text: str) -> str:
    parts = [*answers, *dict.fromkeys(found.remarks)]
    parts += [_act(intent) for intent in found.intents]
    if found.spared:
        names = " and ".join(f"the {as_words(name)}" for name in found.spared)
        parts.append(f"I leave {names}.")
    if not found.intents and found.floating:
        parts.append(Action("look", found.floating[0]).as_tag())
    if not parts:
        parts.append("Hello, what shall I do?" if _GREETING.match(text) else NOT_UNDERSTOOD)
    return " ".join([*parts, DONE])


def _act(intent: Intent) -> str:
    if intent.kind == "speak":
        return Action("speak", text=intent.target).as_tag()
    words = _PHRASES[intent.kind].format(as_words(intent.target))
    return f"{words} {Action(intent.kind, intent.target).as_tag()}".strip()


def _answer(
    sentence: str,
    tokens: Sequence[Token],
    seen: Sequence[Seen],
    groups: Mapping[str, Sequence[str]],
    last: str | None,
) -> tuple[str, str | None]:
    """The answer to a question about what is seen, and the object that it is about."""
    if _ABLE_QUESTION.search(sentence):
        return _ABLE, last
    places = {each.name: each.side for each in seen}
    for token in tokens:
        name = token.value("object")
        if name in places:
            side = "in the middle" if places[name] == "middle" else f"on the {places[name]}"
            look = Action("look", name).as_tag()
            return f"I see the {as_words(name)} {side}. {look}", name
        absent = token.value("absent")
        if absent is not None:
            return f"I do not see {article(absent)} {absent}.", last
    group = next((token.value("group") for token in tokens if "group" in token.meanings), None)
    members = [name for name in places if group is None or name in groups[group]]
    if not members:
        return "I see nothing of that kind on the table.", last
    names = [f"{article(as_words(name))} {as_words(name)}" for name in members]
    listed = ", ".join(names[:-1]) + (" and " if names[1:] else "") + names[-1]
    return f"I see {listed}.", last


def _spoken_of(messages: Sequence[Message]) -> str | None:
    """The last target of an earlier reply, which "it" may mean."""
    for message in reversed(messages):
        if message.role == "assistant" and (found := _TARGET.findall(message.content)):
            return str(found[-1])
    return None
