"""Which optional parts of agent and speech are installed here."""

from __future__ import annotations

import shutil
from importlib.util import find_spec

_PACKAGES = {
    "agent=endpoint": ("openai", "agent"),
    "speech.recogniser=grammar": ("pocketsphinx", "speech"),
    "speech.recogniser=whisper": ("faster_whisper", "whisper"),
}
_PROGRAMS = {"speech.synthesiser=flite": "flite", "speech.synthesiser=espeak_ng": "espeak-ng"}


def missing_parts() -> dict[str, str]:
    """Return what can not be chosen here, and how it is installed."""
    parts = {
        setting: f"the package {package} is not installed (pip install .[{extra}])"
        for setting, (package, extra) in _PACKAGES.items()
        if find_spec(package) is None
    }
    return parts | {
        setting: f"the program {program} is not installed (apt-get install {program})"
        for setting, program in _PROGRAMS.items()
        if shutil.which(program) is None
    }
