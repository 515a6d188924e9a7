"""Types of the trials with an agent and of what is kept of them; conf/grasp owns the values."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from pipeline.checks import at_least, one_of, positive

EVIDENCE = ("failures", "all", "none")


@dataclass
class ProtocolConfig:
    """Rows of things, the sentence that starts them, and what counts as seen."""

    sentence: str = MISSING
    gap: float = MISSING  # m
    located: float = MISSING  # m
    bin_margin: float = MISSING  # m
    evidence: str = MISSING

    def __post_init__(self) -> None:
        """Refuse a protocol without a sentence, or that takes anything for seen."""
        if not self.sentence.strip():
            raise ValueError("grasp.protocol.sentence must not be empty")
        at_least("grasp.protocol.gap", self.gap, 0)
        positive("grasp.protocol.located", self.located)
        at_least("grasp.protocol.bin_margin", self.bin_margin, 0)
        one_of("grasp.protocol.evidence", self.evidence, EVIDENCE)
