"""An agent from its configuration, and the one that needs none: it grasps all that is in view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from pipeline.agent.action import Action
from pipeline.agent.config import AgentConfig
from pipeline.agent.dialogue import Agent
from pipeline.agent.endpoint import Endpoint
from pipeline.agent.errors import SetupError
from pipeline.agent.model import LanguageModel, Message
from pipeline.agent.policy import Policy
from pipeline.agent.recording import Recorder, Replay
from pipeline.agent.scene_text import read_user_text


class GraspAllPolicy:
    """In place of a language model: requests a grasp of all that is in view, from right to left.

    Attributes:
        name: Its name in rows and transcripts.
    """

    name = "none"

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer the last user turn; see `pipeline.agent.model.LanguageModel`."""
        _, seen = read_user_text(messages[-1].content)
        ordered = sorted(seen, key=lambda each: each.position[1])
        tags = [Action("grasp", each.name).as_tag() for each in ordered]
        return " ".join([*tags, Action("done").as_tag()])


def load_model(config: AgentConfig) -> LanguageModel:
    """Return what answers messages.

    Raises:
        SetupError: A package, an address, a key or a file is missing.
    """
    model = _model(config)
    return Recorder(model, config.kind, Path(config.record)) if config.record else model


def _model(config: AgentConfig) -> LanguageModel:
    if config.kind == "replay":
        if not config.file:
            raise SetupError("agent=replay needs agent.file=FILE, which agent.record=FILE wrote")
        return Replay(Path(config.file))
    if config.kind == "policy":
        return Policy(config.vocabulary)
    if config.kind == "endpoint":
        return Endpoint(config.endpoint, config.actions)
    if config.kind == "local":
        from pipeline.agent.local import (
            LocalModel,
        )  # imports torch: seconds that others need not wait

        return LocalModel(config)
    return GraspAllPolicy()


def load_agent(config: AgentConfig, robot: str) -> Agent:
    """Return an agent that begins a conversation as a robot; see `agent_factory`."""
    return agent_factory(config, robot)()


def agent_factory(config: AgentConfig, robot: str) -> Callable[[], Agent]:
    """Return what begins conversations as a robot; the model is loaded once.

    Args:
        config: Which model, and the bounds of a turn.
        robot: Name of the robot.

    Raises:
        SetupError: A package, an address or a key is missing.
    """
    model = load_model(config)
    return lambda: Agent(model, robot, config)


def kind_of(config: AgentConfig, model: LanguageModel) -> str:
    """Return the kind of agent that answers: of a replayed file, the one that was recorded."""
    return model.recorded if isinstance(model, Replay) else config.kind
