"""The conversation of a robot with a person: instructions in, checked actions out, a transcript.

A turn never raises for what the model or the scene does: a reply that cannot be used is a `Turn`
without actions and with a problem, which costs that trial and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from pipeline.agent.action import Action
from pipeline.agent.config import AgentConfig
from pipeline.agent.errors import AgentError, ModelError, Reason
from pipeline.agent.model import LanguageModel, Message
from pipeline.agent.prompt import system_prompt
from pipeline.agent.scene_text import GO_ON, SILENCE, Seen, harmless, labelled, user_text
from pipeline.agent.tags import parse_reply
from pipeline.agent.transcript import Transcript


@dataclass(frozen=True)
class Turn:
    """The result of one reply.

    Attributes:
        actions: What to do, in order; none if there is a problem.
        reply: What the model wrote.
        problem: Nothing, or a reason code, a colon and a sentence.
        reason: The reason code alone, or nothing.
    """

    actions: list[Action]
    reply: str
    problem: str = ""
    reason: str = ""

    @property
    def finished(self) -> bool:
        """Whether the agent says that the instruction is fulfilled, or the turn failed."""
        return bool(self.problem) or any(action.kind == "done" for action in self.actions)


@dataclass
class _Instruction:
    """What has been answered to the instruction at hand."""

    turns: int = 0
    replies: list[str] = field(default_factory=list)


class Agent:
    """A conversation. Make one a trial or `reset` it: earlier turns are shown to the model.

    Attributes:
        model: What answers.
    """

    def __init__(self, model: LanguageModel, robot: str, config: AgentConfig) -> None:
        """Begin a conversation.

        Args:
            model: What answers.
            robot: Name of the robot that the agent is.
            config: Bounds, and what the system prompt says.
        """
        self.model = model
        self._config = config
        self._system = Message("system", system_prompt(robot, config))
        self.reset()

    def reset(self) -> None:
        """Forget the conversation and begin a new transcript."""
        self._past: list[Message] = []
        self._outcomes: list[str] = []
        self._instruction = _Instruction()
        self._transcript = Transcript()
        self._transcript.add("system", self._system.content)

    @property
    def transcript(self) -> list[dict[str, Any]]:
        """Entries since the beginning: role, text, actions, problem, time."""
        return self._transcript.entries

    def instruct(self, instruction: str, sightings: Sequence[Seen]) -> Turn:
        """Answer a new instruction.

        Args:
            instruction: The user's words.
            sightings: What is seen now.

        Returns:
            The actions in order, targets named as in ``sightings``, or a problem.
        """
        self._instruction = _Instruction()
        words = harmless(instruction, self._config.max_instruction_chars)
        return self._turn(words or SILENCE, sightings)

    def proceed(self, sightings: Sequence[Seen]) -> Turn:
        """Go on with the instruction at hand, for models that ask for one action at a time.

        Call it while the turn before is not `finished`, after `report`.
        """
        return self._turn(GO_ON, sightings)

    def report(self, outcome: str) -> None:
        """Report the result of an action; the model reads it in the next user turn."""
        self._outcomes.append(outcome)
        self._transcript.add("body", outcome)

    def _turn(self, words: str, sightings: Sequence[Seen]) -> Turn:
        labels = labelled(sightings)
        message = Message("user", user_text(words, labels, self._outcomes))
        self._outcomes = []
        self._transcript.add("user", message.content)
        turn = self._answer(message, labels)
        self._transcript.add("assistant", turn.reply, turn.actions, turn.problem)
        if turn.reply:
            kept = turn.reply[: self._config.max_reply_chars]
            sendable = kept.encode(errors="replace").decode()  # without half a surrogate pair
            self._past += [message, Message("assistant", sendable)]
        return turn

    def _answer(self, message: Message, labels: dict[str, Seen]) -> Turn:
        reply = ""
        config = self._config
        try:
            if self._instruction.turns >= config.max_turns:
                raise ModelError(
                    Reason.TOO_MANY_TURNS,
                    f"an instruction has at most {config.max_turns} turns, without <done/> so far",
                )
            self._instruction.turns += 1
            shown = self._past[-2 * config.history :] if config.history else []
            reply = self.model.reply([self._system, *shown, message])
            actions = parse_reply(
                reply,
                labels,
                kinds=config.actions,
                longest=config.max_reply_chars,
                most=config.max_actions,
                repeats=config.repeats,
            )
            self._check_progress(reply, actions)
        except AgentError as error:
            return Turn([], reply, str(error), str(error.reason))
        return Turn([_named(action, labels) for action in actions], reply)

    def _check_progress(self, reply: str, actions: Sequence[Action]) -> None:
        """Refuse to act on one and the same reply again and again within an instruction."""
        said = self._instruction.replies
        said.append(reply)
        if said.count(reply) > self._config.repeats and any(a.is_physical for a in actions):
            raise ModelError(
                Reason.LOOP, f"the same reply more than {self._config.repeats} times in a row"
            )


def _named(action: Action, labels: dict[str, Seen]) -> Action:
    """The action with the object's own name in place of its label."""
    seen = labels.get(action.target) if action.kind != "face" else None
    return action if seen is None else replace(action, target=seen.name)
