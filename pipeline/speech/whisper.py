"""Whisper through faster-whisper, with weights from a folder on this machine."""

from __future__ import annotations

from pathlib import Path

from pipeline.errors import SpeechError
from pipeline.packages import optional_package
from pipeline.speech.config import WhisperConfig
from pipeline.speech.sound import read_sound

RATE = 16000  # Hz, of the model
# Without the tokenizer the package would fetch one, and nothing here is fetched.
_FILES = ("model.bin", "config.json", "tokenizer.json")


class WhisperRecogniser:
    """Understands free speech; what it means is the agent's to decide.

    Attributes:
        name: whisper.
    """

    name = "whisper"

    def __init__(self, config: WhisperConfig) -> None:
        """Load the weights.

        Args:
            config: Folder, language and precision.

        Raises:
            SpeechError: The package or the folder is missing, or the folder holds no weights.
        """
        package = optional_package("speech.recogniser=whisper", SpeechError)
        if config.folder is None:
            raise SpeechError(
                "speech.recogniser=whisper needs speech.whisper.folder=<folder of faster-whisper "
                "weights>: none are downloaded"
            )
        folder = Path(config.folder)
        missing = [name for name in _FILES if not (folder / name).is_file()]
        if missing:
            raise SpeechError(
                f"speech.whisper.folder={folder} must hold {', '.join(_FILES)}; "
                f"missing: {', '.join(missing)}"
            )
        self._language = config.language
        try:
            self._model = package.WhisperModel(
                str(folder), device="cpu", compute_type=config.compute, local_files_only=True
            )
        except Exception as error:  # its tokenizer raises bare exceptions for a broken file
            said = " ".join(str(error).split())
            raise SpeechError(f"speech.whisper.folder={folder} cannot be loaded: {said}") from error

    def recognise(self, wav: Path) -> str:
        """Return the words of a WAV file; see `pipeline.speech.protocol.Recogniser`."""
        samples = read_sound(wav, RATE).astype("float32")
        if not len(samples):
            return ""
        segments, _ = self._model.transcribe(
            samples,
            language=self._language,
            beam_size=5,
            temperature=0.0,  # an instruction is one sentence: no second guess by chance
            condition_on_previous_text=False,
            without_timestamps=True,
        )
        return " ".join(segment.text.strip() for segment in segments).strip()
