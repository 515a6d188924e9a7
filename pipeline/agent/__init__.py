"""The chat agent: instructions and what is seen go in, checked actions come out."""

from pipeline.agent.action import Action
from pipeline.agent.dialogue import Agent, Turn
from pipeline.agent.errors import ModelError, Reason, TagError
from pipeline.agent.scene_text import Seen, seen_at
from pipeline.agent.tags import parse_reply

__all__ = [
    "Action",
    "Agent",
    "ModelError",
    "Reason",
    "Seen",
    "TagError",
    "Turn",
    "parse_reply",
    "seen_at",
]
