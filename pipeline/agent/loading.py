"""An agent from its configuration."""

from __future__ import annotations

from pipeline.agent.config import AgentConfig
from pipeline.agent.dialogue import Agent
from pipeline.agent.endpoint import Endpoint
from pipeline.agent.errors import SetupError
from pipeline.agent.model import LanguageModel
from pipeline.agent.policy import Policy


def load_model(config: AgentConfig) -> LanguageModel:
    """Return what answers messages.

    Raises:
        SetupError: There is none, or a package, an address or a key is missing.
    """
    if config.kind == "policy":
        return Policy(config.vocabulary)
    if config.kind == "endpoint":
        return Endpoint(config.endpoint, config.actions)
    raise SetupError("agent=none answers nobody: choose agent=policy or agent=endpoint")


def load_agent(config: AgentConfig, robot: str) -> Agent:
    """Return an agent that begins a conversation as a robot.

    Args:
        config: Which model, and the bounds of a turn.
        robot: Name of the robot.

    Raises:
        SetupError: There is none, or a package, an address or a key is missing.
    """
    return Agent(load_model(config), robot, config)
