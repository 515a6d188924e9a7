"""Recogniser and synthesiser from their configuration."""

from __future__ import annotations

from collections.abc import Iterable

from pipeline.agent.config import VocabularyConfig
from pipeline.errors import SpeechError
from pipeline.speech.config import SpeechConfig
from pipeline.speech.protocol import Recogniser, Synthesiser
from pipeline.speech.synthesiser import EspeakNg, Flite
from pipeline.speech.whisper import WhisperRecogniser


def load_recogniser(
    config: SpeechConfig,
    vocabulary: VocabularyConfig,
    names: Iterable[str],
    robots: Iterable[str],
) -> Recogniser:
    """Return what turns speech to text.

    Args:
        config: Which one.
        vocabulary: The agent's words, of which the grammar is made.
        names: Objects that may be in view.
        robots: Names that the robot may be called by.

    Raises:
        SpeechError: None is chosen, or something is missing.
    """
    if config.recogniser == "grammar":
        from pipeline.speech.grammar_recogniser import GrammarRecogniser  # parsers take time

        return GrammarRecogniser(config, vocabulary, names, robots)
    if config.recogniser == "whisper":
        return WhisperRecogniser(config.whisper)
    raise SpeechError("speech.recogniser=none hears nothing: choose grammar or whisper")


def load_synthesiser(config: SpeechConfig) -> Synthesiser:
    """Return what turns text to speech.

    Args:
        config: Which one, its voice and pace.

    Raises:
        SpeechError: None is chosen, or its program is missing.
    """
    kinds = {"flite": Flite, "espeak_ng": EspeakNg}
    if config.synthesiser in kinds:
        voice = config.voices.get(config.synthesiser, "")
        return kinds[config.synthesiser](voice, config.pace)
    raise SpeechError("speech.synthesiser=none says nothing: choose flite or espeak_ng")
