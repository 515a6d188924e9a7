"""Sound files: 16-bit PCM in, samples at the rate of a recogniser out, and back."""

from __future__ import annotations

import math
import wave
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pipeline.data.files import replacing
from pipeline.errors import SpeechError

LONGEST_S = 60.0  # of a file: an instruction takes seconds
RATES = (4000, 384_000)  # Hz, of files: a resampling filter grows with the rate
FULL_SCALE = 32767


def read_sound(wav: Path, rate: int) -> NDArray[np.float64]:
    """Return the samples of a WAV file as one channel.

    Args:
        wav: 16-bit PCM of a rate within `RATES`, one or more channels, at most a minute.
        rate: Samples a second that are wanted [Hz].

    Returns:
        Samples (N,) in [-1, 1].

    Raises:
        SpeechError: It is no such file, or too long.
    """
    try:
        with wave.open(str(wav), "rb") as stream:
            width, channels, own = (
                stream.getsampwidth(),
                stream.getnchannels(),
                stream.getframerate(),
            )
            frames = stream.getnframes()
            if width != 2 or not RATES[0] <= own <= RATES[1] or frames / own > LONGEST_S:
                raise SpeechError(
                    f"{wav} must hold 16-bit samples of at most {LONGEST_S:g} s at "
                    f"{RATES[0]} to {RATES[1]} Hz, got {8 * width}-bit samples of "
                    f"{frames / max(own, 1):.1f} s at {own} Hz"
                )
            data = stream.readframes(frames)
    except (OSError, EOFError, ValueError, wave.Error) as error:  # a path may not hold a zero byte
        raise SpeechError(f"{wav} cannot be read as a WAV file ({error})") from error
    whole = len(data) // (2 * channels) * 2 * channels
    samples = np.frombuffer(data[:whole], dtype="<i2").reshape(-1, channels).mean(axis=1)
    samples = samples / FULL_SCALE
    if own == rate or not len(samples):
        return samples
    from scipy.signal import resample_poly  # half a second that every command would pay

    common = math.gcd(rate, own)
    resampled: NDArray[np.float64] = resample_poly(samples, rate // common, own // common)
    return resampled


def write_sound(wav: Path, samples: NDArray[np.float64], rate: int) -> None:
    """Write samples (N,) in [-1, 1] as 16-bit PCM of one channel, atomically.

    Args:
        wav: The file that is to appear.
        samples: Samples; what is beyond full scale is clipped.
        rate: Samples a second [Hz].
    """
    with replacing(wav) as partial, wave.open(str(partial), "wb") as stream:
        stream.setnchannels(1)
        stream.setsampwidth(2)
        stream.setframerate(rate)
        stream.writeframes(as_pcm(samples))


def as_pcm(samples: NDArray[np.float64]) -> bytes:
    """Return samples (N,) in [-1, 1] as little-endian 16-bit integers."""
    return (np.clip(samples, -1, 1) * FULL_SCALE).astype("<i2").tobytes()
