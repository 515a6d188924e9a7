"""From the tokens of an instruction to intents: what is to be done with which object, in order.

A small machine that reads from left to right and keeps the last verb: "grasp the banana and the
pear, then point at it" are three intents. It guesses nothing: what it cannot place is a remark.
"""

from __future__ import annotations

from collections.abc import Sequence

from pipeline.agent.action import OF_OBJECTS
from pipeline.agent.intents import ORDERS, Intent, Understanding, article, as_words, pick
from pipeline.agent.lexicon import STOP, Lexicon, Token, is_noun, token_at
from pipeline.agent.scene_text import Seen

_ARTICLES = ("the", "a", "an", "my", "your", "that", "this")
_SINGLE = ("it", "that", "this", "that one", "this one")


class Reader:
    """Reads one instruction."""

    def __init__(
        self,
        lexicon: Lexicon,
        seen: Sequence[Seen],
        groups: dict[str, list[str]],
        last: str | None = None,
    ) -> None:
        """Prepare.

        Args:
            lexicon: Meanings of words.
            seen: What is in view; names are labels.
            groups: Words for several objects, and their names.
            last: The object that was mentioned before, which "it" means.
        """
        self._lexicon, self._groups = lexicon, groups
        self._seen = {each.name: each for each in seen}
        self._order = ORDERS["right_to_left"]
        self._last = [last] if last in self._seen else []
        self.found = Understanding()
        self._verb: str | None = None
        self._targets = 0  # of the verb at hand
        self._many = 0  # intents at the end that are the verb's
        self._negated = self._leave = self._except = self._begin = self._relation = False
        self._unknown = ""

    def read(self, tokens: Sequence[Token]) -> Understanding:
        """Return the meaning of the tokens."""
        skip = 0
        for at, token in enumerate(tokens):
            if skip:
                skip -= 1
                continue
            before = tokens[at - 1] if at else None
            skip = self._take(token, before, tokens[at + 1 :])
        self._end_verb()
        if not self.found.intents and not self.found.remarks:
            for name in self.found.floating[:1]:
                self.found.remarks.append(f"What shall I do with the {as_words(name)}?")
        return self.found

    def _take(self, token: Token, before: Token | None, rest: Sequence[Token]) -> int:
        """Read a token; return how many of the following it used up."""
        m = token.meanings
        follows_object = before is not None and "object" in before.meanings
        if self._verb == "look" and "place" in m and "object" not in m and not follows_object:
            self._emit([m["place"]])
        elif "verb" in m and not (m["verb"] == "look" and self._face_after(rest)):
            return self._begin_verb(m["verb"], rest)
        elif "face" in m and (self._targets or self._verb not in ("grasp", "push")):
            self._express(m["face"])
        elif "object" in m:
            self._unknown = ""
            if not (before is not None and before.text in _ARTICLES and is_noun(token_at(rest, 0))):
                self._emit([m["object"]])  # else it describes the next: the orange ball
        elif "absent" in m:
            self._unknown = ""
            self._miss(m["absent"])
        elif "group" in m or "everything" in m:
            self._emit_many(self._members(token))
        elif "clearing" in m:
            self._begin_verb("grasp", rest)
            self._emit_many(list(self._seen))
        elif "selector" in m and not follows_object:
            return self._select(m["selector"], rest)
        elif "pronouns" in m:
            self._refer(token.text, rest)
        else:
            self._structure(token, before)
        return 0

    def _structure(self, token: Token, before: Token | None) -> None:
        m = token.meanings
        if "order" in m:
            self._order = ORDERS[m["order"]]
            self._sort()
        elif "negations" in m:
            self._negated = True
        elif "exceptions" in m:
            self._except = True
        elif "sequence" in m or m.get("mark") == STOP:
            self._settle_unknown()
            self._negated = self._leave = self._except = self._relation = False
        elif "beginnings" in m:
            self._begin = True
        elif "relations" in m:
            self._settle_unknown()
            self._relation = True
        elif m:  # politeness, idle words, pauses
            self._settle_unknown()
        elif self._unknown or (before is not None and before.text.split()[-1] in _ARTICLES):
            self._unknown = f"{self._unknown} {token.text}".strip()

    def _begin_verb(self, kind: str, rest: Sequence[Token]) -> int:
        self._end_verb()
        self._verb, self._targets, self._many = kind, 0, 0
        self._leave, self._negated, self._except, self._relation = (
            self._negated,
            False,
            False,
            False,
        )
        if kind != "speak":
            return 0
        words: list[str] = []
        for at, token in enumerate(rest):
            ends = "sequence" in token.meanings or token.text == STOP
            if ends or (token.text in ("and", ",") and "verb" in token_at(rest, at + 1).meanings):
                break
            words.append(token.text)
        if words and not self._leave:
            self.found.intents.append(Intent("speak", " ".join(words).replace(" ,", ",")))
            self._targets = 1
        return len(words)

    def _end_verb(self) -> None:
        self._settle_unknown()
        if self._verb in (*OF_OBJECTS, "look") and not self._targets and not self._leave:
            if self.found.floating:
                self._emit(self.found.floating)
                self.found.floating = []
            elif not (self.found.remarks or self.found.intents):
                at = "" if self._verb in ("grasp", "push") else " at"
                self.found.remarks.append(f"What shall I {self._verb}{at}?")
        self._verb = None

    def _emit(self, targets: Sequence[str]) -> None:
        """Give the verb its targets, or take them from it, or keep them for later."""
        kind = self._verb
        intents = self.found.intents
        self._last = [name for name in targets if name in self._seen] or self._last
        if self._relation:
            self.found.remarks.append("I do not know places beside other objects.")
            intents[:] = [intent for intent in intents if intent.kind != kind]
            self._targets, self._many = self._targets + 1, 0
        elif self._except or self._negated:
            spared = [Intent(kind or "", name) for name in targets]
            self._many -= sum(intent in spared for intent in intents[len(intents) - self._many :])
            intents[:] = [intent for intent in intents if intent not in spared]
            self.found.spared += targets
            self._negated = False
        elif self._leave:
            self.found.spared += targets
        elif kind is None or kind in ("face", "speak"):
            self.found.floating += targets
        elif self._begin and self._many:
            new = [Intent(kind, name) for name in targets]
            kept = [i for i in intents[-self._many :] if i not in new]
            intents[-self._many :] = new + kept
            self._begin = False
        else:
            self._append(kind, targets)

    def _append(self, kind: str, targets: Sequence[str]) -> None:
        for name in targets:
            intent = Intent(kind, name)
            self._targets += 1
            again = intent in self.found.intents
            if not (again and (kind == "grasp" or self.found.intents[-1] == intent)):
                self.found.intents.append(intent)
                self._many += 1

    def _emit_many(self, names: Sequence[str]) -> None:
        ordered = sorted(names, key=lambda name: self._order(self._seen[name]))
        if not ordered:
            self._targets += 1
            self.found.remarks.append("I see nothing of that kind.")
            return
        self._emit(ordered)

    def _sort(self) -> None:
        if self._many:
            part = self.found.intents[-self._many :]
            if all(intent.target in self._seen for intent in part):
                part.sort(key=lambda intent: self._order(self._seen[intent.target]))
                self.found.intents[-self._many :] = part

    def _members(self, token: Token) -> list[str]:
        group = token.value("group")
        return [name for name in self._seen if group is None or name in self._groups[group]]

    def _select(self, selector: str, rest: Sequence[Token]) -> int:
        following = token_at(rest, 0)
        if "object" in following.meanings:
            return 0
        several = "group" in following.meanings or "everything" in following.meanings
        names = self._members(following) if several else list(self._seen)
        if not names:
            self._emit_many(names)
            return int(several)
        self._emit([pick(selector, [self._seen[name] for name in names])])
        return int(several)

    def _refer(self, text: str, rest: Sequence[Token]) -> None:
        following = token_at(rest, 0).meanings
        if text in ("that", "this", "those", "these") and (
            "object" in following or "absent" in following or "group" in following
        ):
            return
        if not self._last:
            if self._verb is not None:
                self._targets += 1
                self.found.remarks.append("I do not know which object you mean.")
            return
        self._emit(self._last[-1:] if text in _SINGLE else list(self._last))

    def _express(self, face: str) -> None:
        if not (self._negated or self._leave):
            self.found.intents.append(Intent("face", face))
            self._many = 0
        self._targets += 1

    def _face_after(self, rest: Sequence[Token]) -> bool:
        """Whether "look" is followed by an expression: look happy."""
        return "face" in token_at(rest, 0).meanings

    def _miss(self, what: str) -> None:
        if not (self._leave or self._negated or self._except):
            self._targets += 1
            self.found.remarks.append(f"I do not see {article(what)} {what}.")

    def _settle_unknown(self) -> None:
        if self._unknown and (self._verb in (*OF_OBJECTS, "look")):
            self._miss(self._unknown)
        self._unknown = ""
