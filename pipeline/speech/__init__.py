"""Speech in and out: recognisers and synthesisers behind protocols, all optional, all offline."""

from pipeline.errors import SpeechError
from pipeline.speech.loading import load_recogniser, load_synthesiser
from pipeline.speech.protocol import Recogniser, Synthesiser

__all__ = ["Recogniser", "SpeechError", "Synthesiser", "load_recogniser", "load_synthesiser"]
