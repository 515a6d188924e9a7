"""Trials without an agent: whatever is seen is grasped, from right to left, and nothing is said."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from pipeline.agent import Action, Agent
from pipeline.agent.config import AgentConfig
from pipeline.agent.loading import load_model
from pipeline.agent.model import Message
from pipeline.agent.scene_text import read_user_text


class GraspAllPolicy:
    """Stands in for a language model: asks for a grasp of all that is in view.

    Attributes:
        name: What stands in rows and transcripts.
    """

    name = "none"

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer the last user turn; see `pipeline.agent.model.LanguageModel`."""
        _, seen = read_user_text(messages[-1].content)
        ordered = sorted(seen, key=lambda each: each.position[1])
        tags = [Action("grasp", each.name).as_tag() for each in ordered]
        return " ".join([*tags, Action("done").as_tag()])


def agents(config: AgentConfig, robot: str) -> Callable[[], Agent]:
    """Return what begins a conversation as a robot; the model is loaded once.

    Raises:
        SetupError: A package, an address or a key is missing.
    """
    model = GraspAllPolicy() if config.kind == "none" else load_model(config)
    return lambda: Agent(model, robot, config)
