"""Speech in the loop: word errors by hand, and rows of objects whose sentence is heard."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.errors import ConfigError, SpeechError
from pipeline.speech.loop import Ear, load_ear, word_error_rate
from pipeline.speech.microphone import RATE
from pipeline.speech.sound import read_sound, write_sound
from pipeline.stages import grasp


@pytest.mark.parametrize(
    ("said", "heard", "errors", "words"),
    [
        ("Take the pear, please.", "take the pear please", 0, 4),
        ("take the pear", "take a pear", 1, 3),
        ("take the pear", "take the the pear", 1, 3),
        ("take the pear", "pear", 2, 3),
        ("take the pear", "", 3, 3),
        ("...", "pear", 1, 1),
        ("pear", "take the red pear", 3, 1),
        ("a b c d", "b c d a", 2, 4),
    ],
)
def test_word_errors_by_hand(said: str, heard: str, errors: int, words: int) -> None:
    assert word_error_rate(said, heard) == errors / words


class Tone:
    """A speaker whose every utterance is a second of a tone."""

    def __init__(self, name: str) -> None:
        self.name, self.said = name, [""]

    def speak(self, text: str, wav: Path) -> None:
        self.said.append(text)
        write_sound(wav, 0.9 * np.sin(np.arange(RATE) * 0.3), RATE)


class Measuring:
    """A recogniser that understands nothing and measures the noise."""

    name = "measuring"

    def recognise(self, wav: Path) -> str:
        samples = read_sound(wav, RATE)
        tone = np.sin(np.arange(RATE) * 0.3)
        tone *= (samples @ tone) / (tone @ tone)
        self.snr_db = 10 * np.log10(np.mean(tone**2) / np.mean((samples - tone) ** 2))
        self.samples = samples
        return ""


@pytest.mark.parametrize("snr_db", [0.0, 20.0, 40.0])
def test_the_noise_is_as_loud_as_asked_and_speakers_take_turns(snr_db: float) -> None:
    speakers, recogniser = [Tone("one"), Tone("other")], Measuring()
    ear = Ear(speakers, recogniser, snr_db, seed=0)
    for number in range(3):
        assert ear.hear("hello", number).error_rate == 1.0
        assert recogniser.snr_db == pytest.approx(snr_db, abs=0.6)
    assert [len(speaker.said) - 1 for speaker in speakers] == [2, 1]
    last = recogniser.samples
    ear.hear("hello", 2)
    assert np.array_equal(recogniser.samples, last)


def test_nobody_speaks_by_default_and_silly_noise_is_refused() -> None:
    config = compose(["robot=nico", "agent=policy"])
    names = config.grasp.scenes["nico"].objects
    assert load_ear(config.speech, config.agent.vocabulary, names, "nico", 0) is None
    with pytest.raises(ConfigError, match=r"speech\.loop\.snr_db"):
        compose(["speech.loop.snr_db=200"])


def test_voices_without_an_agent_are_refused() -> None:
    config = compose(["robot=nico", "experiment=spoken", "agent=none", "profile=smoke"])
    with pytest.raises(ConfigError, match="choose agent=policy"):
        grasp.check(config)


@pytest.mark.skipif(shutil.which("flite") is None, reason="flite is not installed")
def test_a_voice_that_nobody_has_is_refused() -> None:
    config = compose(["robot=nico", "experiment=spoken", "speech.loop.voices=[slt,rns]"])
    with pytest.raises(SpeechError, match="rns"):
        load_ear(config.speech, config.agent.vocabulary, ["pear"], "nico", 0)


@pytest.mark.skipif(shutil.which("flite") is None, reason="flite is not installed")
def test_the_papers_sentence_is_understood_in_a_quiet_room() -> None:
    pytest.importorskip("pocketsphinx", reason="the extra `speech` is not installed")
    config = compose(["robot=nico", "experiment=spoken", "speech.loop.snr_db=60"])
    names = config.grasp.scenes["nico"].objects
    ear = load_ear(config.speech, config.agent.vocabulary, names, "nico", 0)
    assert ear is not None
    words = config.grasp.protocol.sentence.format(robot="NICO")
    for number in range(4):
        heard = ear.hear(words, number)
        assert heard.error_rate == 0.0, heard.words
