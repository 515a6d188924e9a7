"""Language models behind an OpenAI-compatible chat endpoint, local or remote.

What the endpoint sends is not trusted: its size and the time it takes are bounded, it is read as
JSON and nothing else, and every way to go wrong is a `ModelError`.
"""

from __future__ import annotations

import json
import os
import threading
import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pipeline.agent.config import EndpointConfig, check_address
from pipeline.agent.errors import AgentError, ModelError, Reason, SetupError
from pipeline.agent.model import Message
from pipeline.agent.tools import tags_of_calls, tool_schema
from pipeline.packages import optional_package

LARGEST = 1 << 20  # bytes of an answer; a reply of the longest kind is a thousandth of it
NO_KEY = "none"  # what servers that need no key are sent: the client refuses an empty one


class Endpoint:
    """A chat endpoint.

    Attributes:
        name: The model's name, which appears in rows and transcripts.
    """

    def __init__(self, config: EndpointConfig, kinds: Sequence[str] = ()) -> None:
        """Look up address and key; no connection is made yet.

        Args:
            config: Where it is and how long it may take.
            kinds: Actions to offer as tools, if ``config.tools``.

        Raises:
            SetupError: The package `openai`, the address, the model's name or the key is missing.
        """
        openai = optional_package("agent=endpoint", SetupError)
        self._config = config
        self.name = _setting(config.model, "OPENAI_MODEL", "agent.endpoint.model", "NAME")
        address = _setting(
            config.base_url, "OPENAI_BASE_URL", "agent.endpoint.base_url", "http://host:8000/v1"
        )
        try:
            check_address("agent.endpoint.base_url", address)
        except ValueError as error:
            raise SetupError(str(error)) from error
        self._key = _key(config)
        self._tools = tool_schema(list(kinds)) if config.tools else []
        self._client = openai.OpenAI(
            api_key=self._key,
            base_url=address,
            timeout=config.timeout_s,
            max_retries=config.retries,
        )

    def reply(self, messages: Sequence[Message]) -> str:
        """Ask the endpoint; see `pipeline.agent.model.LanguageModel`.

        Raises:
            ModelError: Late, unreachable, refused, no chat completion, or empty.
            TagError: A tool call whose argument holds a bracket.
        """
        text = _reply_of(self._ask(self._request(messages)))
        return text.replace(self._key, "***") if self._key != NO_KEY else text

    def _request(self, messages: Sequence[Message]) -> dict[str, Any]:
        request: dict[str, Any] = {
            "model": self.name,
            "messages": [{"role": each.role, "content": each.content} for each in messages],
        }
        for setting in ("temperature", "max_tokens", "seed"):
            value = getattr(self._config, setting)
            if value is not None:  # some servers refuse settings that they do not know
                request[setting] = value
        if self._tools:
            request["tools"] = self._tools
        return request

    def _ask(self, request: dict[str, Any]) -> bytes:
        """The answer's body, before the deadline.

        The client's own limit counts each read of the line anew, so a server that sends a byte a
        second would never be late; the thread is what makes the deadline hold.
        """
        answer: list[bytes | AgentError] = []
        over = time.monotonic() + self._config.deadline_s

        def work() -> None:
            try:
                answer.append(self._fetch(request, over))
            except Exception as error:  # whatever the line does costs a turn, never the run
                answer.append(_as_model_error(error, self._config.timeout_s))

        thread = threading.Thread(target=work, name="endpoint", daemon=True)
        thread.start()
        thread.join(self._config.deadline_s)
        if not answer:
            raise self._late()
        if isinstance(answer[0], AgentError):
            raise answer[0]
        return answer[0]

    def _fetch(self, request: dict[str, Any], over: float) -> bytes:
        """The answer's body; the line is let go when the time is over, as nobody waits any more."""
        body = b""
        with self._client.chat.completions.with_streaming_response.create(**request) as response:
            for chunk in response.iter_bytes():
                body += chunk
                if len(body) > LARGEST:
                    raise ModelError(Reason.BAD_ANSWER, f"an answer of more than {LARGEST} bytes")
                if time.monotonic() > over:
                    raise self._late()
        return body

    def _late(self) -> ModelError:
        return ModelError(Reason.TIMEOUT, f"no answer within {self._config.deadline_s:g} s")


def resolved(config: EndpointConfig) -> EndpointConfig:
    """Return the settings with the model and the address that the environment sets.

    Rows depend on these two as well, wherever they are set.
    """
    model = config.model or os.environ.get("OPENAI_MODEL")
    return replace(
        config, model=model, base_url=config.base_url or os.environ.get("OPENAI_BASE_URL")
    )


def _reply_of(body: bytes) -> str:
    """The text and the tool calls of a chat completion."""
    try:
        answer = json.loads(body)
    except (ValueError, RecursionError) as error:
        raise ModelError(Reason.BAD_ANSWER, "the answer is not JSON") from error
    choices = answer.get("choices") if isinstance(answer, Mapping) else None
    choice = choices[0] if isinstance(choices, list) and choices else None
    message = choice.get("message") if isinstance(choice, Mapping) else None
    if not isinstance(message, Mapping):
        raise ModelError(Reason.BAD_ANSWER, "the answer is no chat completion with a message")
    text = message.get("content")
    if text is not None and not isinstance(text, str):
        raise ModelError(Reason.BAD_ANSWER, "the content of the message is no text")
    reply = f"{text or ''} {tags_of_calls(message.get('tool_calls'))}".strip()
    if not reply:
        raise ModelError(Reason.EMPTY_REPLY, "the message has neither text nor a tool call")
    return reply


def _as_model_error(error: Exception, timeout_s: float) -> AgentError:
    """A fault of the line as a reason; its own words may hold the key and are left out."""
    openai = optional_package("agent=endpoint", SetupError)
    if isinstance(error, AgentError):
        return error
    if isinstance(error, openai.APITimeoutError) or "Timeout" in type(error).__name__:
        return ModelError(Reason.TIMEOUT, f"no answer within {timeout_s:g} s")
    if isinstance(error, openai.APIStatusError):
        return ModelError(Reason.REFUSED, f"the endpoint answered with status {error.status_code}")
    return ModelError(Reason.CONNECTION, f"no connection ({type(error).__name__})")


def _setting(value: str | None, variable: str, key: str, example: str) -> str:
    found = value or os.environ.get(variable, "")
    if not found:
        raise SetupError(f"agent=endpoint needs {key}={example}, or the variable {variable}")
    return found


def _key(config: EndpointConfig) -> str:
    if config.key_file is None:
        return os.environ.get(config.key_variable, "").strip() or NO_KEY
    try:
        key = Path(config.key_file).read_text(encoding="utf-8").strip()
    except (OSError, UnicodeDecodeError) as error:
        raise SetupError(
            f"agent.endpoint.key_file={config.key_file} cannot be read as text"
        ) from error
    return key or NO_KEY
