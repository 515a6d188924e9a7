"""Types of the `speech` group; conf/speech owns the values and comments every key with its unit."""

from __future__ import annotations

from dataclasses import dataclass, field

from omegaconf import MISSING

from pipeline.checks import one_of, positive, within

RECOGNISERS = ("grammar", "whisper", "none")
SYNTHESISERS = ("flite", "espeak_ng", "none")


@dataclass
class WhisperConfig:
    """Whisper from weights on this machine."""

    folder: str | None = None
    language: str = MISSING
    compute: str = MISSING

    def __post_init__(self) -> None:
        """Refuse unknown precisions."""
        one_of("speech.whisper.compute", self.compute, ("int8", "float32"))


@dataclass
class MicrophoneConfig:
    """When an instruction ends."""

    device: str | None = None
    max_duration_s: float = MISSING
    silence_s: float = MISSING
    level: float = MISSING

    def __post_init__(self) -> None:
        """Refuse to listen for no time."""
        positive("speech.microphone.max_duration_s", self.max_duration_s)
        positive("speech.microphone.silence_s", self.silence_s)
        within("speech.microphone.level", self.level, 0, 1)


@dataclass
class LoopConfig:
    """Speech in the loop of grasp trials."""

    voices: list[str] = MISSING
    snr_db: float = MISSING  # dB

    def __post_init__(self) -> None:
        """Refuse noise that no recording has."""
        within("speech.loop.snr_db", self.snr_db, -20.0, 100.0)


@dataclass
class SpeechConfig:
    """Which recogniser, which synthesiser."""

    recogniser: str = MISSING
    synthesiser: str = MISSING
    voices: dict[str, str] = MISSING
    pace: float = MISSING
    rejection: float = MISSING
    pronunciations: dict[str, str] = MISSING
    whisper: WhisperConfig = field(default_factory=WhisperConfig)
    loop: LoopConfig = field(default_factory=LoopConfig)
    microphone: MicrophoneConfig = field(default_factory=MicrophoneConfig)

    def __post_init__(self) -> None:
        """Refuse recognisers and synthesisers that do not exist."""
        one_of("speech.recogniser", self.recogniser, RECOGNISERS)
        one_of("speech.synthesiser", self.synthesiser, SYNTHESISERS)
        for name in self.voices if isinstance(self.voices, dict) else ():
            one_of("speech.voices", name, SYNTHESISERS)
        within("speech.pace", self.pace, 0.3, 3.0)
        positive("speech.rejection", self.rejection)
