"""Recorded exchanges answer again as they did; a hostile file costs its replies and no more."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from pipeline.agent import Agent, ModelError, Reason
from pipeline.agent.errors import SetupError
from pipeline.agent.loading import load_agent
from pipeline.agent.model import Message
from pipeline.agent.recording import LONGEST_LINE, Recorder, Replay

ASKED = [Message("user", "grasp the pear")]
KEYS = [{"role": "user", "content": "grasp the pear"}]


def test_replies_and_faults_come_back_in_turn(scripted, tmp_path: Path) -> None:
    fault = ModelError(Reason.TIMEOUT, "no answer within 1 s")
    model = Recorder(scripted("one", fault, "half a pair \ud800"), "policy", tmp_path / "r.jsonl")
    for expected in ("one", fault, "half a pair \ud800"):
        if isinstance(expected, ModelError):
            with pytest.raises(ModelError, match="timeout: no answer"):
                model.reply(ASKED)
        else:
            assert model.reply(ASKED) == expected
    replay = Replay(tmp_path / "r.jsonl")
    assert replay.recorded == "policy"
    assert replay.reply(ASKED) == "one"
    with pytest.raises(ModelError, match="timeout: no answer within 1 s"):
        replay.reply(ASKED)
    assert [replay.reply(ASKED), replay.reply(ASKED)] == ["half a pair \ud800"] * 2
    with pytest.raises(ModelError, match="not_recorded"):
        replay.reply([Message("user", "grasp the ball")])


def test_a_conversation_is_replayed_without_its_model(config, scene, tmp_path: Path) -> None:
    recording = replace(config, record=str(tmp_path / "r.jsonl"))
    says = ("point at the pear", "grasp it", "grasp the unicorn")
    first, again = load_agent(recording, "nicol"), None
    turns = [first.instruct(words, scene) for words in says]
    again = load_agent(replace(config, kind="replay", file=recording.record), "nicol")
    assert [again.instruct(words, scene) for words in says] == turns
    assert [each.actions[-2].target for each in turns[:2]] == ["pear", "pear"]


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ({"reply": "</grasp><grasp>pear</grasp>"}, "half_tag"),
        ({"reply": "<grasp>../../etc/passwd</grasp>"}, "not_in_view"),
        ({"reply": "<run>rm</run>"}, "unknown_action"),
        ({"reply": "<grasp>pear</grasp>" * 1000}, "too_long"),
        ({"reply": "x" * LONGEST_LINE}, "not_recorded"),
        ({"reply": ["<grasp>pear</grasp>"]}, "not_recorded"),
        ({"reason": "made up", "sentence": "no"}, "not_recorded"),
        ({"reason": "timeout", "sentence": "late"}, "timeout"),
        ({"agent": 3, "reply": "<done/>"}, "not_recorded"),
        ({}, "not_recorded"),
        ("{", "not_recorded"),
        ("[" * 100_000, "not_recorded"),
        ("null", "not_recorded"),
    ],
    ids=lambda value: str(value)[:30],
)
def test_a_hostile_line_costs_its_reply(config, scene, scripted, tmp_path, line, reason) -> None:
    path = tmp_path / "hostile.jsonl"
    probe = scripted("<done/>")
    Agent(probe, "nicol", config).instruct("grasp the pear", scene)
    asked = [{"role": each.role, "content": each.content} for each in probe.requested[0]]
    written = line if isinstance(line, str) else json.dumps({"asked": asked, "agent": "x", **line})
    other = json.dumps({"asked": KEYS, "agent": "../x", "reply": "<done/>"})
    path.write_bytes(f"{written}\n{other}".encode() + b"\n\xff\xfe\n")
    agent = load_agent(replace(config, kind="replay", file=str(path)), "nicol")
    turn = agent.instruct("grasp the pear", scene)
    assert (turn.reason, turn.actions) == (reason, [])
    assert agent.model.reply(ASKED) == "<done/>"
    assert agent.model.recorded == "replay"


def test_files_that_cannot_be_are_refused(config, tmp_path: Path) -> None:
    for file in (tmp_path, tmp_path / "none.jsonl", Path("/dev/zero")):
        with pytest.raises(SetupError, match=r"agent\.file=.* cannot be read"):
            load_agent(replace(config, kind="replay", file=str(file)), "nicol")
    with pytest.raises(SetupError, match=r"agent=replay needs agent\.file=FILE"):
        load_agent(replace(config, kind="replay"), "nicol")
    (tmp_path / "file").touch()
    with pytest.raises(SetupError, match=r"agent\.record=.* cannot be written"):
        load_agent(replace(config, record=str(tmp_path / "file" / "r.jsonl")), "nicol")
