"""Optional packages and programs: missing ones are a sentence and a line of the doctor."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pipeline.errors import SpeechError
from pipeline.packages import PACKAGES, missing_parts, optional_package


def test_the_doctor_knows_what_is_missing(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert "apt-get install flite" in missing_parts()["speech.synthesiser=flite"]
    monkeypatch.setattr("pipeline.packages.find_spec", lambda name: None)
    missing = missing_parts()
    assert "pip install .[agent]" in missing["agent=endpoint"]
    assert set(PACKAGES) <= set(missing)


def test_a_missing_package_names_setting_package_and_extra(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "faster_whisper", None)
    words = r"recogniser=whisper needs the package faster-whisper.*'cycleik-bench\[whisper\]', too$"
    with pytest.raises(SpeechError, match=words):
        optional_package("speech.recogniser=whisper", SpeechError, ", too")


def test_a_package_that_is_there_is_imported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(PACKAGES, "engine=ray", ("json", "ray"))
    assert optional_package("engine=ray").loads("1") == 1
