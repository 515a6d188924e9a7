"""Synthesisers that are programs of the system: flite and espeak-ng."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

from pipeline.data.files import replacing
from pipeline.errors import SpeechError
from robots.suggestions import unknown_name

LONGEST = 1000  # characters of one utterance
TIMEOUT_S = 30.0
_WORDS_PER_MINUTE = 175  # espeak-ng's own pace


class _Program:
    """A program that speaks a text file to a WAV file."""

    name = ""
    program = ""

    def __init__(self, voice: str, pace: float) -> None:
        """Look for the program.

        Args:
            voice: Name of a voice of the program.
            pace: Times the voice's own speed.

        Raises:
            SpeechError: The program is not installed, or the voice's name is none.
        """
        found = shutil.which(self.program)
        if found is None:
            raise SpeechError(
                f"speech.synthesiser={self.name} needs the program {self.program} "
                f"(Debian: apt-get install {self.program})"
            )
        if (
            not voice
            or voice.startswith("-")
            or not voice.replace("-", "").replace("_", "").isalnum()
        ):
            raise SpeechError(
                f"speech.voices.{self.name} must be a voice of {self.program}, got '{voice}'"
            )
        self._found, self._voice, self._pace = found, voice, pace

    def speak(self, text: str, wav: Path) -> None:
        """Write the text as speech; see `pipeline.speech.protocol.Synthesiser`."""
        words = " ".join(text.split())[:LONGEST]
        with replacing(wav) as partial:
            # The words go in through a file, so nothing in them can be an option of the program.
            script = partial.with_suffix(".txt")
            try:
                script.write_text(words + "\n", encoding="utf-8", errors="replace")
                self._run(self._options(script, partial))
            finally:
                script.unlink(missing_ok=True)
            if not partial.exists():
                raise SpeechError(
                    f"{self.program} wrote no sound; is there a voice '{self._voice}'?"
                )

    def _options(self, script: Path, wav: Path) -> list[str]:
        raise NotImplementedError

    def _run(self, options: Sequence[str]) -> None:
        try:
            done = subprocess.run(
                [self._found, *options],
                stdin=subprocess.DEVNULL,
                capture_output=True,
                timeout=TIMEOUT_S,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise SpeechError(
                f"{self.program} could not be run ({type(error).__name__})"
            ) from error
        if done.returncode:
            said = done.stderr.decode(errors="replace").strip().splitlines()
            raise SpeechError(f"{self.program} failed: {said[0] if said else done.returncode}")


class Flite(_Program):
    """flite: voices made of recordings, which recognisers understand well."""

    name = "flite"
    program = "flite"

    def check_voice(self) -> None:
        """Refuse a voice that the program does not have: it would speak with another, in silence.

        Raises:
            SpeechError: There is none of that name.
        """
        listed = subprocess.run([self._found, "-lv"], capture_output=True, text=True, check=False)
        _, _, names = listed.stdout.partition(":")
        if names.split() and self._voice not in names.split():
            raise SpeechError(unknown_name("voice of flite", self._voice, names.split()))

    def _options(self, script: Path, wav: Path) -> list[str]:
        stretch = f"duration_stretch={1.0 / self._pace:.3f}"
        return ["-voice", self._voice, "-f", str(script), "--setf", stretch, "-o", str(wav)]


class EspeakNg(_Program):
    """espeak-ng: small, many languages, a synthetic sound."""

    name = "espeak_ng"
    program = "espeak-ng"

    def _options(self, script: Path, wav: Path) -> list[str]:
        pace = str(round(_WORDS_PER_MINUTE * self._pace))
        return ["-v", self._voice, "-s", pace, "-f", str(script), "-w", str(wav)]
