"""Lines of a conversation without a simulator: text, sounds, what is shown and what is kept."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pipeline.agent import Agent
from pipeline.agent.model import Message
from pipeline.agent.transcript import read_transcript
from pipeline.config import compose
from pipeline.embodiment.chat import Chat
from pipeline.embodiment.perception import View
from pipeline.embodiment.session import Session
from pipeline.errors import SpeechError
from pipeline.grasping.outcome import ActionResult, GraspReport
from pipeline.perception.detection import Detection, Sighting

AGENT = compose(["agent=policy"]).agent


class Model:
    name = "scripted"

    def __init__(self, reply: str) -> None:
        self.answer, self.requested = reply, ""

    def reply(self, messages: Sequence[Message]) -> str:
        self.requested = messages[-1].content
        return self.answer


class Ears:
    name = "ears"

    def recognise(self, wav: Path) -> str:
        if not wav.exists():
            raise SpeechError(f"there is no {wav.name}")
        return "grasp the pear"

    def speak(self, text: str, wav: Path) -> None:
        wav.write_text(text)


@pytest.fixture
def shown() -> list[str]:
    return []


def a_chat(reply: str, shown: list[str], folder: Path, speech: Any = Ears) -> Chat:
    """A chat whose body does everything at once and whose eyes see a pear."""
    detection = Detection("pear", 0.9, (0, 0, 9, 9), (4, 4))
    view = View(None, [Sighting(detection, np.array([0.4, 0.1, 0.8]))])
    body = SimpleNamespace(
        scene=SimpleNamespace(time_s=1.5),
        report=GraspReport(),
        act=lambda kind, place, name, object_id: ActionResult(True, "moved it"),
    )
    obj = SimpleNamespace(body=3, name="pear")
    objects = SimpleNamespace(
        nearest=lambda place: (obj, 0.0),
        positions=lambda: np.zeros((1, 3)),
        named=lambda _: obj,
    )
    perception = SimpleNamespace(look=lambda scene, objects: view)
    agent = Agent(Model(reply), "nicol", AGENT)
    session = Session(agent, body, perception, objects, 0.04)  # type: ignore[arg-type]
    return Chat(
        session, "NICOL", folder / "chat.jsonl", shown.append, speech, speech,
        lambda wav: bool(wav.write_text("sound")),
    )  # fmt: skip


def test_a_typed_line_is_acted_on_shown_and_kept(shown: list[str], tmp_path: Path) -> None:
    chat = a_chat("I push it. <push>pear</push> <face>happiness</face> <done/>", shown, tmp_path)
    assert chat.line("push the pear")
    text = "\n".join(shown)
    for said in ('NICOL: "I push it."', "push pear: done, moved it", "face happiness"):
        assert said in text
    assert "40 cm ahead, 10 cm to the left" in text
    entries = read_transcript(chat.transcript)
    kinds = [entry["kind"] for entry in entries if entry["role"] == "event"]
    assert kinds == ["speak", "push", "face"]
    assert not list(tmp_path.glob("*.wav")), "a typed instruction is not answered aloud"


def test_a_reply_that_cannot_be_used_is_said_and_the_talk_goes_on(
    shown: list[str], tmp_path: Path
) -> None:
    chat = a_chat("<grasp>unicorn</grasp>", shown, tmp_path)
    assert chat.line("grasp the unicorn")
    assert any("no answer that can be used: not_in_view" in line for line in shown)


def test_quit_help_and_look(shown: list[str], tmp_path: Path) -> None:
    chat = a_chat("<done/>", shown, tmp_path)
    assert not chat.line(" Quit ")
    assert chat.line("help")
    assert "quit" in shown[-1]
    assert chat.line("look")
    assert "pear" in shown[-1]
    assert chat.line("thank you")
    assert any("nothing to do" in line for line in shown)


def test_a_spoken_instruction_is_recognised_and_answered_aloud(
    shown: list[str], tmp_path: Path
) -> None:
    wav = tmp_path / "order.wav"
    wav.write_text("sound")
    chat = a_chat("I take it. <grasp>pear</grasp> <done/>", shown, tmp_path)
    chat.line(str(wav))
    assert "heard: grasp the pear" in shown
    assert chat.session.agent.model.requested.startswith("grasp the pear")  # type: ignore[attr-defined]
    assert (tmp_path / "chat_01_said.wav").read_text() == "I take it."
    chat.line("listen")
    assert (tmp_path / "chat_02_heard.wav").exists()


def test_what_cannot_be_heard_is_a_sentence(shown: list[str], tmp_path: Path) -> None:
    chat = a_chat("<done/>", shown, tmp_path)
    assert chat.line(str(tmp_path / "missing.wav"))
    assert shown == ["not heard: there is no missing.wav"]

    def missing() -> Ears:
        raise SpeechError("pocketsphinx is not installed: pip install 'cycleik-bench[speech]'")

    chat = a_chat("<done/>", shown, tmp_path, speech=missing)
    chat.line(str(tmp_path / "any.wav"))
    assert "pocketsphinx is not installed" in shown[-1]
