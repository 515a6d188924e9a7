"""Exchanges with a language model as JSON lines: written while it answers, and answered from.

A line has the messages that were asked (`asked`: role and content of each), the kind of agent and
its `reply`, or `reason` and `sentence` of the fault. A replayed file is not trusted: what
cannot be read as such a line is left out, and a reply from it is checked like any other.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pipeline.agent.config import AGENTS
from pipeline.agent.errors import AgentError, ModelError, Reason, SetupError
from pipeline.agent.model import LanguageModel, Message

LONGEST_LINE = 1 << 20  # bytes; a longer one is left out


class Recorder:
    """A language model whose exchanges are kept.

    Attributes:
        name: The model's.
    """

    def __init__(self, model: LanguageModel, kind: str, path: Path) -> None:
        """Record a model.

        Args:
            model: What answers.
            kind: Of the agent, as in the configuration.
            path: File that a line is added to for each reply.

        Raises:
            SetupError: The file cannot be written.
        """
        self._model, self._kind, self._path, self.name = model, kind, path, model.name
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
        except OSError as error:
            raise SetupError(f"agent.record={path} cannot be written: {error.strerror}") from error

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer and keep the answer; see `pipeline.agent.model.LanguageModel`."""
        try:
            reply = self._model.reply(messages)
        except AgentError as error:
            self._keep(messages, {"reason": str(error.reason), "sentence": error.sentence})
            raise
        self._keep(messages, {"reply": reply})
        return reply

    def _keep(self, messages: Sequence[Message], answer: Mapping[str, str]) -> None:
        """Add a line in one write, so that several processes may record into one file."""
        line = json.dumps({"asked": _asked(messages), "agent": self._kind, **answer})
        with self._path.open("ab", buffering=0) as file:
            file.write(f"{line}\n".encode())


class Replay:
    """Answers from a recorded file what was answered there, without a model.

    The same messages get their recorded replies in turn, and the last of them from then on.

    Attributes:
        name: Its name in transcripts.
        recorded: Kind of the agent that was recorded, "replay" if the file does not say.
    """

    name = "replay"

    def __init__(self, path: Path) -> None:
        """Read a file.

        Raises:
            SetupError: There is no such file, or it cannot be read.
        """
        self._answers: dict[str, list[Mapping[str, str]]] = {}
        self.recorded = self.name
        try:
            for asked, agent, answer in _exchanges(path):
                self._answers.setdefault(asked, []).append(answer)
                self.recorded = agent if agent in AGENTS else self.recorded
        except OSError as error:
            raise SetupError(f"agent.file={path} cannot be read: {error.strerror}") from error

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer the last message; see `pipeline.agent.model.LanguageModel`.

        Raises:
            ModelError: These messages are not in the file, or it has a fault for them.
        """
        answers = self._answers.get(json.dumps(_asked(messages)))
        if not answers:
            raise ModelError(Reason.NOT_RECORDED, "the file has no reply to these messages")
        answer = answers.pop(0) if len(answers) > 1 else answers[0]
        if "reply" in answer:
            return answer["reply"]
        raise ModelError(Reason(answer["reason"]), answer["sentence"])


def _exchanges(path: Path) -> Iterator[tuple[str, str, Mapping[str, str]]]:
    """Yield what was asked, the agent and its answer, of each line that has them."""
    if not path.is_file():
        raise FileNotFoundError(2, "there is no such file")
    with path.open("rb") as file:
        whole = True
        while line := file.readline(LONGEST_LINE):
            begins, whole = whole, line.endswith(b"\n")
            if begins and (whole or len(line) < LONGEST_LINE):
                yield from _exchange(line)


def _exchange(line: bytes) -> Iterator[tuple[str, str, Mapping[str, str]]]:
    try:
        content = json.loads(line)
    except (ValueError, RecursionError):
        return
    if not isinstance(content, dict) or not isinstance(content.get("asked"), list):
        return
    answer = {key: content[key] for key in ("reply", "reason", "sentence") if key in content}
    fault = {"reason", "sentence"} <= set(answer) and answer["reason"] in set(Reason)
    agent = content.get("agent")
    if all(isinstance(each, str) for each in (agent, *answer.values())) and (
        "reply" in answer or fault
    ):
        yield json.dumps(content["asked"]), str(agent), answer


def _asked(messages: Sequence[Message]) -> list[dict[str, Any]]:
    return [{"role": each.role, "content": each.content} for each in messages]
