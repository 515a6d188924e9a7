"""What can go wrong in a turn of the agent, as codes that trials are classed by."""

from __future__ import annotations

from enum import StrEnum

from pipeline.errors import PipelineError


class Reason(StrEnum):
    """Why a turn has no actions. The value appears in rows and transcripts."""

    NO_ACTION = "no_action"  # words without a single tag
    HALF_TAG = "half_tag"  # a bracket that belongs to no whole tag
    UNKNOWN_ACTION = "unknown_action"  # a tag off the whitelist
    NOT_IN_VIEW = "not_in_view"  # an object that the camera does not see
    BAD_TARGET = "bad_target"  # an empty or impossible target: a face that there is not
    TOO_LONG = "too_long"  # more characters than a reply may have
    TOO_MANY_ACTIONS = "too_many_actions"  # more actions than a reply may have
    LOOP = "loop"  # the same action, or the same reply, again and again
    TOO_MANY_TURNS = "too_many_turns"  # an instruction that does not end
    TIMEOUT = "timeout"  # no answer in time
    CONNECTION = "connection"  # nobody listens, or the line broke
    REFUSED = "refused"  # the endpoint answered with an error status
    BAD_ANSWER = "bad_answer"  # an answer that is no chat completion
    NOT_RECORDED = "not_recorded"  # messages that a replayed file has no reply to
    EMPTY_REPLY = "empty_reply"  # a completion without text or tool call


class AgentError(PipelineError):
    """A fault of a turn: a code to class it by, and a sentence.

    Attributes:
        reason: The code.
        sentence: What was expected and what came.
    """

    def __init__(self, reason: Reason, sentence: str) -> None:
        super().__init__(f"{reason}: {sentence}")
        self.reason = reason
        self.sentence = sentence


class TagError(AgentError):
    """A reply that is not in the tag language, or requests what is not possible."""


class ModelError(AgentError):
    """A language model that gave no reply."""


class SetupError(PipelineError):
    """An agent that cannot be made: a package, an address or a key is missing."""
