"""Sound files, the end of an utterance, and synthesisers that no text can steer."""

from __future__ import annotations

import shutil
import sys
import types
import wave
from pathlib import Path

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.errors import ConfigError
from pipeline.speech import SpeechError, load_recogniser, load_synthesiser
from pipeline.speech.config import MicrophoneConfig, WhisperConfig
from pipeline.speech.microphone import BLOCK_S, RATE, Utterance
from pipeline.speech.sound import read_sound, write_sound
from pipeline.speech.synthesiser import EspeakNg, Flite
from pipeline.speech.whisper import WhisperRecogniser


@pytest.fixture(scope="module")
def composed():
    return compose(["speech=none"])


def test_a_sound_comes_back_at_another_rate(tmp_path):
    t = np.arange(22050) / 22050
    write_sound(tmp_path / "tone.wav", 0.5 * np.sin(2 * np.pi * 440 * t), 22050)
    samples = read_sound(tmp_path / "tone.wav", 16000)
    assert samples.shape == (16000,)
    wanted = 0.5 * np.sin(2 * np.pi * 440 * np.arange(16000) / 16000)
    assert np.abs(samples - wanted)[200:-200].max() < 0.01


def test_channels_are_averaged_and_loud_ones_clipped(tmp_path):
    write_sound(tmp_path / "loud.wav", np.array([2.0, -2.0]), 16000)
    assert np.allclose(read_sound(tmp_path / "loud.wav", 16000), [1, -1])
    with wave.open(str(tmp_path / "two.wav"), "wb") as stream:
        stream.setparams((2, 2, 16000, 0, "NONE", ""))
        stream.writeframes(np.array([100, 300, -100, -300], "<i2").tobytes())
    assert np.allclose(read_sound(tmp_path / "two.wav", 16000) * 32767, [200, -200])


@pytest.mark.parametrize("content", [b"", b"RIFF", b"RIFF\x24\x00\x00\x00WAVEfmt ", b"x" * 5000])
def test_what_is_no_sound_is_refused(tmp_path, content):
    (tmp_path / "bad.wav").write_bytes(content)
    with pytest.raises(SpeechError, match=r"bad\.wav"):
        read_sound(tmp_path / "bad.wav", 16000)


def test_missing_long_and_eight_bit_files_are_refused(tmp_path):
    with pytest.raises(SpeechError, match="cannot be read"):
        read_sound(tmp_path / "none.wav", 16000)
    write_sound(tmp_path / "long.wav", np.zeros(61 * 8000), 8000)
    with pytest.raises(SpeechError, match="at most 60 s"):
        read_sound(tmp_path / "long.wav", 16000)
    with wave.open(str(tmp_path / "eight.wav"), "wb") as stream:
        stream.setparams((1, 1, 16000, 0, "NONE", ""))
        stream.writeframes(bytes(100))
    with pytest.raises(SpeechError, match="8-bit"):
        read_sound(tmp_path / "eight.wav", 16000)


@pytest.mark.parametrize("rate", [1, 2**31 - 1])
def test_rates_that_no_recording_has_are_refused(tmp_path, rate):
    """A resampling filter for the greater one would take hundreds of gigabytes."""
    path = tmp_path / "odd.wav"
    write_sound(path, np.zeros(10), 16000)
    content = bytearray(path.read_bytes())
    content[24:28] = rate.to_bytes(4, "little")
    path.write_bytes(content)
    with pytest.raises(SpeechError, match=f"at {rate} Hz"):
        read_sound(path, 16000)


def test_a_path_that_cannot_be_is_refused():
    with pytest.raises(SpeechError, match="cannot be read"):
        read_sound(Path("a\0.wav"), 16000)


def test_an_utterance_ends_with_silence_or_at_last():
    config = MicrophoneConfig(None, max_duration_s=3.0, silence_s=0.5, level=0.01)
    loud, quiet = np.full(int(BLOCK_S * RATE), 0.1), np.zeros(int(BLOCK_S * RATE))
    heard = Utterance(config)
    for block in [quiet] * 10 + [loud] * 5 + [quiet] * 4:
        heard.add(block)
        assert not heard.ended
    heard.add(quiet)
    assert heard.ended
    assert heard.has_speech
    assert heard.samples.shape == (20 * int(BLOCK_S * RATE),)
    silent = Utterance(config)
    while not silent.ended:
        silent.add(quiet)
    assert not silent.has_speech
    assert len(silent.samples) == 3 * RATE


def test_what_is_missing_is_said(composed, monkeypatch, tmp_path):
    with pytest.raises(SpeechError, match="choose grammar"):
        load_recogniser(composed.speech, composed.agent.vocabulary, ["banana"], ["nicol"])
    with pytest.raises(SpeechError, match="choose flite"):
        load_synthesiser(composed.speech)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SpeechError, match="apt-get install flite"):
        Flite("slt", 1.0)
    with pytest.raises(SpeechError, match="apt-get install espeak-ng"):
        EspeakNg("en-us", 1.0)


def test_a_missing_package_is_said(composed, monkeypatch):
    for module in ("pocketsphinx", "faster_whisper"):
        monkeypatch.setitem(sys.modules, module, None)
    composed.speech.recogniser = "grammar"
    with pytest.raises(SpeechError, match=r"cycleik-bench\[speech\]"):
        load_recogniser(composed.speech, composed.agent.vocabulary, ["banana"], ["nicol"])
    with pytest.raises(SpeechError, match=r"cycleik-bench\[whisper\]"):
        WhisperRecogniser(WhisperConfig("x", "en", "int8"))


class _Whisper(types.ModuleType):
    """Stands for the package: remembers how it was called."""

    def __init__(self):
        super().__init__("faster_whisper")
        self.calls = []
        outer = self

        class WhisperModel:
            def __init__(self, folder, **settings):
                outer.calls.append((folder, settings))

            def transcribe(self, samples, **settings):
                outer.calls.append((samples.dtype.name, samples.shape, settings))
                return iter([types.SimpleNamespace(text=" Grasp the"), _SEGMENT]), None

        self.WhisperModel = WhisperModel


_SEGMENT = types.SimpleNamespace(text=" banana. ")


def test_whisper_loads_a_folder_and_nothing_else(tmp_path, monkeypatch):
    package = _Whisper()
    monkeypatch.setitem(sys.modules, "faster_whisper", package)
    with pytest.raises(SpeechError, match="none are downloaded"):
        WhisperRecogniser(WhisperConfig(None, "en", "int8"))
    with pytest.raises(SpeechError, match=r"missing: model\.bin"):
        WhisperRecogniser(WhisperConfig(str(tmp_path), "en", "int8"))
    for name in ("model.bin", "config.json", "tokenizer.json"):
        (tmp_path / name).touch()
    recogniser = WhisperRecogniser(WhisperConfig(str(tmp_path), "en", "int8"))
    folder, settings = package.calls[0]
    assert folder == str(tmp_path)
    assert settings["local_files_only"] is True
    write_sound(tmp_path / "said.wav", np.zeros(8000), 8000)
    assert recogniser.recognise(tmp_path / "said.wav") == "Grasp the banana."
    assert package.calls[1][:2] == ("float32", (16000,))


@pytest.mark.parametrize("voice", ["", "-o", "../etc", "http://host/voice", "a b", "$(id)"])
def test_a_voice_is_a_name(voice, tmp_path, monkeypatch):
    _pretend(tmp_path, monkeypatch, "flite", "exit 0")
    with pytest.raises(SpeechError, match="voice"):
        Flite(voice, 1.0)


@pytest.mark.parametrize("kind", [Flite, EspeakNg])
def test_words_are_no_options_and_no_commands(kind, tmp_path, monkeypatch):
    """The program gets its words in a file; what it is called with does not hold them."""
    log = tmp_path / "called"
    script = f'printf "%s\\n" "$@" > {log}; for last; do :; done; echo RIFF > "$last"'
    _pretend(tmp_path, monkeypatch, kind.program, script)
    words = "-o /etc/x; $(touch hacked) `id` <grasp>"
    kind("slt", 1.0).speak(words, tmp_path / "said.wav")
    assert (tmp_path / "said.wav").exists()
    assert not any(part in log.read_text() for part in ("touch", "/etc/x", "grasp"))
    assert sorted(path.name for path in tmp_path.iterdir()) == ["called", "program", "said.wav"]


def test_a_failing_program_leaves_no_file(tmp_path, monkeypatch):
    _pretend(tmp_path, monkeypatch, "flite", "echo no such voice >&2; exit 3")
    with pytest.raises(SpeechError, match="no such voice"):
        Flite("slt", 1.0).speak("hello", tmp_path / "said.wav")
    assert not (tmp_path / "said.wav").exists()


def _pretend(folder, monkeypatch, program, script):
    path = folder / "program" / program
    path.parent.mkdir()
    path.write_text(f"#!/bin/sh\n{script}\n")
    path.chmod(0o755)
    monkeypatch.setenv("PATH", f"{path.parent}:/usr/bin:/bin")


def test_what_cannot_be_is_refused_at_the_command_line():
    with pytest.raises(ConfigError, match=r"speech\.recogniser"):
        compose(["speech.recogniser=telepathy"])


@pytest.mark.parametrize(("kind", "voice"), [("flite", "slt"), ("espeak_ng", "en-us")])
def test_each_synthesiser_speaks_with_a_voice_of_its_own(kind, voice, tmp_path, monkeypatch):
    config = compose([f"speech.synthesiser={kind}"]).speech
    assert config.voices[kind] == voice
    program = {"flite": "flite", "espeak_ng": "espeak-ng"}[kind]
    if shutil.which(program) is None:
        pytest.skip(f"the program {program} is not installed")
    load_synthesiser(config).speak("The banana, please.", tmp_path / "said.wav")
    samples = read_sound(tmp_path / "said.wav", 16000)
    assert 0.5 < len(samples) / 16000 < 4.0
    assert np.abs(samples).max() > 0.05
