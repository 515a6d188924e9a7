"""Whisper with real, if random, weights: the smallest model that the package loads."""

from __future__ import annotations

import numpy as np
import pytest

from pipeline.speech import SpeechError
from pipeline.speech.config import WhisperConfig
from pipeline.speech.sound import write_sound
from pipeline.speech.whisper import WhisperRecogniser

pytestmark = pytest.mark.slow
pytest.importorskip("faster_whisper", reason="the extra 'whisper' is not installed")
transformers = pytest.importorskip("transformers", reason="transformers makes the tiny weights")
VOCABULARY = 51865  # of Whisper for many languages


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    import tokenizers
    import torch
    from ctranslate2.converters.transformers import WhisperLoader
    from faster_whisper.tokenizer import _LANGUAGE_CODES

    torch.manual_seed(0)
    size = {"d_model": 64, "encoder_layers": 1, "decoder_layers": 1, "vocab_size": VOCABULARY}
    heads = {"encoder_attention_heads": 2, "decoder_attention_heads": 2}
    model = transformers.WhisperForConditionalGeneration(
        transformers.WhisperConfig(**size, **heads, encoder_ffn_dim=64, decoder_ffn_dim=64)
    ).eval()
    languages = [f"<|{code}|>" for code in _LANGUAGE_CODES[:99]]
    tasks = ("translate", "transcribe", "startoflm", "startofprev", "nospeech", "notimestamps")
    special = ["<|endoftext|>", "<|startoftranscript|>", *languages]
    special += [f"<|{task}|>" for task in tasks]
    special += [f"<|{0.02 * step:.2f}|>" for step in range(1501)]
    words = [*(f"w{i}" for i in range(VOCABULARY - len(special))), *special]
    spec = WhisperLoader().get_model_spec(model)
    spec.register_vocabulary(words)
    spec.config.suppress_ids, spec.config.suppress_ids_begin = [], []
    spec.config.alignment_heads = [(0, 0)]
    spec.config.lang_ids = [words.index(code) for code in languages]
    spec.validate()
    spec.optimize()
    path = tmp_path_factory.mktemp("whisper")
    spec.save(str(path))
    numbers = {word: i for i, word in enumerate(words)}
    tokenizer = tokenizers.Tokenizer(tokenizers.models.WordLevel(numbers, unk_token="w0"))
    tokenizer.add_special_tokens([tokenizers.AddedToken(word, special=True) for word in special])
    tokenizer.save(str(path / "tokenizer.json"))
    return path


def test_random_weights_say_something(folder, tmp_path):
    write_sound(tmp_path / "said.wav", np.random.default_rng(0).normal(0, 0.1, 16000), 16000)
    recogniser = WhisperRecogniser(WhisperConfig(str(folder), "en", "int8"))
    words = recogniser.recognise(tmp_path / "said.wav").split()
    assert all(word.startswith("w") for word in words)


@pytest.mark.parametrize("name", ["model.bin", "config.json", "tokenizer.json"])
def test_broken_weights_are_refused_by_their_folder(folder, name):
    path = folder / name
    content = path.read_bytes()
    path.write_bytes(b"junk")
    try:
        with pytest.raises(SpeechError, match="cannot be loaded"):
            WhisperRecogniser(WhisperConfig(str(folder), "en", "int8"))
    finally:
        path.write_bytes(content)
