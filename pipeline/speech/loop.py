"""Speech in the loop: what a person says to the robot is spoken, heard in noise and recognised."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from pipeline.agent.config import VocabularyConfig
from pipeline.seeding import derive_seed
from pipeline.speech.config import SpeechConfig
from pipeline.speech.loading import load_recogniser, load_synthesiser
from pipeline.speech.microphone import RATE
from pipeline.speech.protocol import Recogniser, Synthesiser
from pipeline.speech.sound import read_sound, write_sound
from pipeline.speech.synthesiser import Flite

LOUDEST = 0.9  # of full scale


@dataclass(frozen=True)
class Heard:
    """What arrived of an utterance.

    Attributes:
        words: As recognised; nothing if nothing was understood.
        error_rate: Words inserted, left out and replaced, over the words that were said.
    """

    words: str
    error_rate: float


@dataclass(frozen=True)
class Ear:
    """People who speak, a room with white noise, and a recogniser.

    Attributes:
        speakers: Utterances in turns.
        recogniser: Understands them.
        snr_db: Power of the speech over that of the noise [dB].
        seed: Root seed of the noise.
    """

    speakers: Sequence[Synthesiser]
    recogniser: Recogniser
    snr_db: float
    seed: int

    def hear(self, text: str, number: int) -> Heard:
        """Return what is heard when something is said.

        Args:
            text: What is said.
            number: Of the utterance: it chooses the speaker and draws the noise.

        Raises:
            SpeechError: The synthesiser failed.
        """
        draw = np.random.default_rng(derive_seed(self.seed, "speech", number))
        with TemporaryDirectory() as folder:
            wav = Path(folder) / "said.wav"
            self.speakers[number % len(self.speakers)].speak(text, wav)
            speech = read_sound(wav, RATE)
            power = float(np.mean(speech**2)) / 10.0 ** (self.snr_db / 10.0)
            sound = speech + np.sqrt(power) * draw.standard_normal(len(speech))
            peak = float(np.abs(sound).max(initial=0.0))
            write_sound(wav, sound * (LOUDEST / max(peak, 1e-9)), RATE)
            words = self.recogniser.recognise(wav)
        return Heard(words, word_error_rate(text, words))


def load_ear(
    config: SpeechConfig,
    vocabulary: VocabularyConfig,
    names: Sequence[str],
    robot: str,
    seed: int,
) -> Ear | None:
    """Return the ear of a configuration; None where nobody speaks.

    Args:
        config: Speakers, noise and recogniser.
        vocabulary: The agent's words, of which the grammar is made.
        names: Objects that may be in view.
        robot: Name that the robot is called by.
        seed: Root seed of the noise.

    Raises:
        SpeechError: A program, a package or a voice is missing.
    """
    voices = config.loop.voices
    if not voices:
        return None
    speakers = [
        load_synthesiser(replace(config, voices={**config.voices, config.synthesiser: voice}))
        for voice in voices
    ]
    for speaker in speakers:
        if isinstance(speaker, Flite):
            speaker.check_voice()
    return Ear(
        speakers, load_recogniser(config, vocabulary, names, [robot]), config.loop.snr_db, seed
    )


def word_error_rate(said: str, heard: str) -> float:
    """Return the edit distance of words over the number of words said, Levenshtein's.

    Case and punctuation do not count.

    Args:
        said: What was said; of nothing every word that is heard counts as one.
        heard: What was recognised.
    """
    said_words, heard_words = (re.findall(r"[a-z0-9']+", text.lower()) for text in (said, heard))
    distances = list(range(len(heard_words) + 1))
    for row, word in enumerate(said_words, start=1):
        before, distances[0] = distances[0], row
        for column, other in enumerate(heard_words, start=1):
            least = min(before + (word != other), distances[column] + 1, distances[column - 1] + 1)
            before, distances[column] = distances[column], least
    return distances[-1] / max(len(said_words), 1)
