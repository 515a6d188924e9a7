"""The system prompt: who the agent is, what it senses, what it can do, and the tag language."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

from pipeline.agent.action import FACES, PLACES
from pipeline.agent.config import AgentConfig

if TYPE_CHECKING:
    from jinja2 import Environment

TEMPLATE = "system.jinja"
UNKNOWN_BODY = "{name}, a robot arm with a hand beside a table."


def system_prompt(robot: str, config: AgentConfig) -> str:
    """Return the system message for a robot.

    Args:
        robot: Name of the robot; without an entry in ``agent.bodies`` it is described in general.
        config: Bodies, senses and allowed actions.
    """
    body = config.bodies.get(robot) or UNKNOWN_BODY.format(name=robot)
    return _render(body, config.perception, tuple(config.actions)).strip()


def _render(body: str, perception: str, actions: Sequence[str]) -> str:
    template = _environment().get_template(TEMPLATE)
    return template.render(
        body=body, perception=perception, actions=actions, places=PLACES, faces=FACES
    )


@cache
def _environment() -> Environment:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # only talking needs it

    # The result is plain text for a model, not HTML: nothing is to be escaped for a browser.
    return Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        autoescape=False,
    )
