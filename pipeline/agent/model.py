"""Language models behind one protocol: messages in, a reply in the tag language out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

ROLES = ("system", "user", "assistant")


@dataclass(frozen=True)
class Message:
    """One message of a conversation.

    Attributes:
        role: One of `ROLES`.
        content: Text; of a user turn the instruction and what is seen (`scene_text`).
    """

    role: str
    content: str


class LanguageModel(Protocol):
    """What answers messages.

    Attributes:
        name: Its name in rows and transcripts.
    """

    name: str

    def reply(self, messages: Sequence[Message]) -> str:
        """Answer the last message.

        Args:
            messages: The system message and the conversation, a user turn last.

        Returns:
            Free text with action tags. It is not trusted: `parse_reply` checks it.

        Raises:
            ModelError: No reply came: late, broken, empty or refused.
        """
        ...
