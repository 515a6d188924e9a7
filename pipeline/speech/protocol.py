"""What recognises and what speaks."""

from __future__ import annotations

from pathlib import Path
from typing import Protocol


class Recogniser(Protocol):
    """Speech to text.

    Attributes:
        name: Its name in transcripts.
    """

    name: str

    def recognise(self, wav: Path) -> str:
        """Return the words of a WAV file; nothing if none were understood.

        Args:
            wav: 16-bit PCM of any rate, one or more channels.

        Raises:
            SpeechError: It is no such file.
        """
        ...


class Synthesiser(Protocol):
    """Text to speech.

    Attributes:
        name: Its name in transcripts.
    """

    name: str

    def speak(self, text: str, wav: Path) -> None:
        """Write the text as speech to a WAV file (16-bit PCM, one channel), atomically.

        Args:
            text: Words; nothing in them is an option or a command.
            wav: The file that is to appear.

        Raises:
            SpeechError: The program is missing or failed.
        """
        ...
