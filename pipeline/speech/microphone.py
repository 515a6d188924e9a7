"""An instruction from the microphone: recorded until the speaker is silent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import SpeechError
from pipeline.packages import optional_package
from pipeline.speech.config import MicrophoneConfig
from pipeline.speech.sound import write_sound

PORT_AUDIO = " and PortAudio (Debian: apt-get install libportaudio2)"
RATE = 16000  # Hz
BLOCK_S = 0.1  # s of sound that are judged at once


def record(config: MicrophoneConfig, wav: Path) -> bool:
    """Record an instruction to a WAV file.

    Args:
        config: Device, and when an instruction ends.
        wav: The file that is to appear.

    Returns:
        Whether anybody spoke; if not, no file appears.

    Raises:
        SpeechError: The package `sounddevice`, its library or a microphone is missing.
    """
    package = optional_package("the microphone", SpeechError, PORT_AUDIO)
    device = config.device
    heard = Utterance(config)
    try:
        with package.InputStream(
            samplerate=RATE,
            channels=1,
            dtype="float32",
            blocksize=int(BLOCK_S * RATE),
            device=int(device) if device is not None and device.isdigit() else device,
        ) as stream:
            while not heard.ended:
                block, _ = stream.read(int(BLOCK_S * RATE))
                heard.add(np.asarray(block[:, 0], dtype=np.float64))
    except (package.PortAudioError, ValueError) as error:
        raise SpeechError(f"no microphone can be opened ({error})") from error
    if not heard.has_speech:
        return False
    write_sound(wav, heard.samples, RATE)
    return True


class Utterance:
    """Blocks of sound until the speaker has been silent for a while.

    Attributes:
        has_speech: Whether anything was loud enough to be speech.
    """

    def __init__(self, config: MicrophoneConfig) -> None:
        """Begin to listen.

        Args:
            config: When an instruction ends.
        """
        self._config = config
        self._blocks: list[NDArray[np.float64]] = []
        self._silent_s = 0.0
        self.has_speech = False

    def add(self, block: NDArray[np.float64]) -> None:
        """Take `BLOCK_S` seconds of samples in [-1, 1]."""
        self._blocks.append(block)
        loud = float(np.sqrt(np.mean(block**2))) > self._config.level
        self.has_speech |= loud
        self._silent_s = 0.0 if loud else self._silent_s + BLOCK_S

    @property
    def ended(self) -> bool:
        """Whether the instruction is over, or nobody began one in time."""
        if len(self._blocks) * BLOCK_S >= self._config.max_duration_s:
            return True
        return self.has_speech and self._silent_s >= self._config.silence_s

    @property
    def samples(self) -> NDArray[np.float64]:
        """All that was heard, (N,) in [-1, 1] at `RATE`."""
        return np.concatenate(self._blocks) if self._blocks else np.zeros(0)
