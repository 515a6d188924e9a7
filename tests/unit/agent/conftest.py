"""A scene, and the agent's configuration."""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy

import pytest

from pipeline.agent.config import AgentConfig
from pipeline.agent.model import Message
from pipeline.agent.scene_text import Seen, seen_at
from pipeline.config import compose


@pytest.fixture(scope="session")
def composed() -> AgentConfig:
    return compose(["agent=policy"]).agent


@pytest.fixture
def config(composed: AgentConfig) -> AgentConfig:
    return deepcopy(composed)  # composing takes half a second


@pytest.fixture
def scene() -> list[Seen]:
    places = {
        "soup_can": (0.50, 0.20),
        "baseball": (0.50, 0.04),
        "banana": (0.52, -0.10),
        "pear": (0.45, -0.30),
        "orange": (0.55, -0.45),
    }
    return [seen_at(name, x, y, 0.95) for name, (x, y) in places.items()]


class Scripted:
    """A model that gives the replies it was made with; an error among them is raised."""

    name = "scripted"

    def __init__(self, *replies: str | Exception) -> None:
        self.replies = list(replies)
        self.requested: list[list[Message]] = []

    def reply(self, messages: Sequence[Message]) -> str:
        self.requested.append(list(messages))
        reply = self.replies.pop(0) if len(self.replies) > 1 else self.replies[0]
        if isinstance(reply, Exception):
            raise reply
        return reply


@pytest.fixture
def scripted() -> type[Scripted]:
    return Scripted
