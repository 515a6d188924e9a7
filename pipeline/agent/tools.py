"""The actions as tools of the chat API, and a model's tool calls as tags.

A tool call comes to the same text as a tag, so there is one parser that decides what is allowed.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

from pipeline.agent.action import FACES, PLACES
from pipeline.agent.errors import ModelError, Reason, TagError

# kind: what it does, name of the argument, what the argument is
_TOOLS: dict[str, tuple[str, str, str]] = {
    "grasp": ("Grasp an object and drop it into a bin.", "name", "an object in view"),
    "push": ("Push an object a little along the table.", "name", "an object in view"),
    "point": ("Point at an object.", "name", "an object in view"),
    "look": ("Look somewhere.", "name", f"an object in view or one of {', '.join(PLACES)}"),
    "face": ("Show a face expression.", "name", f"one of {', '.join(FACES)}"),
    "speak": ("Say words aloud.", "name", "the words"),
    "done": ("Say that the instruction is fulfilled.", "", ""),
}
_NAME = re.compile(r"[a-z_]{1,40}")


def tool_schema(kinds: list[str]) -> list[dict[str, Any]]:
    """Return the ``tools`` of a chat completion request for the actions that are allowed."""
    return [_tool(kind, *_TOOLS[kind]) for kind in kinds]


def tags_of_calls(calls: Any) -> str:
    """Return tool calls as tags, in order.

    Args:
        calls: ``tool_calls`` of a message, as it came; not trusted.

    Raises:
        ModelError: They are no tool calls.
        TagError: An argument holds a bracket.
    """
    if calls is None:
        return ""
    if not isinstance(calls, list):
        raise ModelError(Reason.BAD_ANSWER, "tool_calls must be a list")
    return " ".join(_tag(call) for call in calls)


def _tool(kind: str, does: str, argument: str, meaning: str) -> dict[str, Any]:
    properties = {argument: {"type": "string", "description": meaning}} if argument else {}
    parameters = {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }
    function = {"name": kind, "description": does, "parameters": parameters}
    return {"type": "function", "function": function}


def _tag(call: Any) -> str:
    function = call.get("function") if isinstance(call, Mapping) else None
    name = function.get("name") if isinstance(function, Mapping) else None
    if not isinstance(name, str) or not _NAME.fullmatch(name):
        raise ModelError(Reason.BAD_ANSWER, "a tool call must name a function")
    if name == "done":
        return "<done/>"
    assert isinstance(function, Mapping)
    value = _only_argument(function.get("arguments"))
    if "<" in value or ">" in value:
        raise TagError(Reason.HALF_TAG, f"the argument of {name} must hold no bracket")
    return f"<{name}>{value}</{name}>"


def _only_argument(arguments: Any) -> str:
    """The one string among the arguments; servers send JSON in a string, or the object itself."""
    try:
        content = json.loads(arguments) if isinstance(arguments, str) else arguments
    except (ValueError, RecursionError) as error:
        raise ModelError(Reason.BAD_ANSWER, "arguments of a tool call must be JSON") from error
    values = list(content.values()) if isinstance(content, Mapping) else []
    if len(values) != 1 or not isinstance(values[0], str):
        raise ModelError(Reason.BAD_ANSWER, "a tool call must have one argument, a string")
    return values[0]
