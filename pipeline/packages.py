"""Optional packages and programs: imported where a setting needs them, or reported as missing."""

from __future__ import annotations

import shutil
from importlib import import_module
from importlib.util import find_spec
from typing import Any

from pipeline.errors import PipelineError

# What needs it, as a user sets it: module, and the extra of this project that brings it.
PACKAGES = {
    "agent=endpoint": ("openai", "agent"),
    "agent=local": ("gguf", "local_llm"),
    "export to=onnx": ("onnx", "export"),
    "the check of to=onnx": ("onnxruntime", "export"),
    "engine=ray": ("ray", "ray"),
    "engine=slurm": ("submitit", "cluster"),
    "perception.detector=open_vocabulary": ("transformers", "perception"),
    "speech.recogniser=grammar": ("pocketsphinx", "speech"),
    "speech.recogniser=whisper": ("faster_whisper", "whisper"),
    "the microphone": ("sounddevice", "speech"),
    "the live view": ("viser", "view"),
}
PROGRAMS = {"speech.synthesiser=flite": "flite", "speech.synthesiser=espeak_ng": "espeak-ng"}


def optional_package(
    setting: str, error: type[PipelineError] = PipelineError, hint: str = ""
) -> Any:
    """Import the package that a setting needs.

    Args:
        setting: A key of `PACKAGES`.
        error: What is raised where it is missing.
        hint: What must be installed besides, as the end of the sentence.

    Returns:
        The module.

    Raises:
        PipelineError: As ``error``; it cannot be imported.
    """
    module, extra = PACKAGES[setting]
    try:
        return import_module(module)
    except (ImportError, OSError) as problem:  # the latter of a shared library that is missing
        raise error(
            f"{setting} needs the package {_distribution(module)}, which cannot be imported "
            f"({problem}); install it with: pip install 'cycleik-bench[{extra}]'{hint}"
        ) from problem


def missing_parts() -> dict[str, str]:
    """Return the settings that cannot be chosen here, and how to install what they need."""
    packages = {
        setting: f"the package {_distribution(module)} is not installed (pip install .[{extra}])"
        for setting, (module, extra) in PACKAGES.items()
        if find_spec(module) is None
    }
    return packages | {
        setting: f"the program {program} is not installed (apt-get install {program})"
        for setting, program in PROGRAMS.items()
        if shutil.which(program) is None
    }


def _distribution(module: str) -> str:
    """Name of a module's package in an index."""
    return module.replace("_", "-")
