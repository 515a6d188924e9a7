"""The offline recogniser: pocketsphinx with a grammar, and a second pass that may refuse."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pipeline.agent.config import VocabularyConfig
from pipeline.errors import SpeechError
from pipeline.packages import optional_package
from pipeline.speech.config import SpeechConfig
from pipeline.speech.grammar import SpokenGrammar
from pipeline.speech.sound import as_pcm, read_sound

RATE = 16000  # Hz, of the acoustic model
_PADDING_S = 0.2  # s of silence on both sides, which the model expects
_LOUDNESS = 0.4  # peak after scaling, as in the recordings that the model learned from
_QUIET = 1e-4  # peak below which there is nothing to recognise
_LOG_BASE = math.log(1.0001)  # of the decoder's scores


class GrammarRecogniser:
    """Understands the sentences of the agent's vocabulary and no others.

    A grammar fits every sound to some sentence. So the sound is also decoded as free phones; where
    these fit better by more than ``speech.rejection`` a frame, nothing was understood.

    Attributes:
        name: grammar.
    """

    name = "grammar"

    def __init__(
        self,
        config: SpeechConfig,
        vocabulary: VocabularyConfig,
        names: Iterable[str],
        robots: Iterable[str] = (),
    ) -> None:
        """Build the grammar and load the acoustic model.

        Args:
            config: Pronunciations and the limit of rejection.
            vocabulary: The agent's words.
            names: Objects that may be in view.
            robots: Names that the robot may be called by.

        Raises:
            SpeechError: The package `pocketsphinx` is missing.
        """
        package = optional_package("speech.recogniser=grammar", SpeechError)
        model = package.get_model_path("en-us/en-us")
        common = {"hmm": model, "lm": None, "samprate": RATE, "loglevel": "FATAL"}
        self._decoder = package.Decoder(
            package.Config(dict=package.get_model_path("en-us/cmudict-en-us.dict"), **common)
        )
        for word, phones in config.pronunciations.items():
            if self._decoder.lookup_word(word) is None:
                self._decoder.add_word(word, phones, False)
        self.grammar = SpokenGrammar(vocabulary, names, robots, self._knows)
        arcs = [arc if arc[3] else arc[:3] for arc in self.grammar.arcs()]
        self._decoder.add_fsg("instruction", self._decoder.create_fsg("instruction", 0, 1, arcs))
        self._decoder.activate_search("instruction")
        phones_model = package.get_model_path("en-us/en-us-phone.lm.bin")
        self._phones = package.Decoder(
            package.Config(dict=None, allphone=phones_model, beam=1e-10, pbeam=1e-10, **common)
        )
        self._rejection = config.rejection

    def recognise(self, wav: Path) -> str:
        """Return the words of a WAV file; see `pipeline.speech.protocol.Recogniser`."""
        return self.recognise_samples(read_sound(wav, RATE))

    def recognise_samples(self, samples: NDArray[np.float64]) -> str:
        """Return the words of samples (N,) at `RATE`; nothing if none were understood."""
        words, excess = self.scored(samples)
        return words if excess <= self._rejection else ""

    def scored(self, samples: NDArray[np.float64]) -> tuple[str, float]:
        """Return the sentence that fits best, and by how much a frame free phones fit better."""
        peak = float(np.abs(samples).max(initial=0.0))
        if peak < _QUIET:
            return "", math.inf
        silence = np.zeros(int(_PADDING_S * RATE))
        sound = as_pcm(np.concatenate([silence, samples * (_LOUDNESS / peak), silence]))
        words, fit = _decode(self._decoder, sound)
        if not words:
            return "", math.inf
        _, free = _decode(self._phones, sound)
        return words, (free - fit) / max(self._decoder.n_frames(), 1)

    def _knows(self, word: str) -> bool:
        return self._decoder.lookup_word(word) is not None


def _decode(decoder: Any, sound: bytes) -> tuple[str, float]:
    """The best hypothesis and its score in the decoder's units."""
    decoder.start_utt()
    decoder.process_raw(sound, no_search=False, full_utt=True)
    decoder.end_utt()
    best = decoder.hyp()
    if best is None or best.score <= 0:
        return "", -math.inf
    return best.hypstr, math.log(best.score) / _LOG_BASE
