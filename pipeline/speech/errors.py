"""Errors of speech: a package or program that is missing, or a sound that cannot be used."""

from __future__ import annotations

from pipeline.errors import PipelineError


class SpeechError(PipelineError):
    """Speech that cannot be had here; says what is missing and how to get it."""
