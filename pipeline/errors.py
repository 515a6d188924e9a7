"""Errors that a user can correct: the command line prints them as one line and exits with 2."""

from __future__ import annotations


class PipelineError(ValueError):
    """Bad input, in one sentence that names what was expected and what to do."""


class ConfigError(PipelineError):
    """A configuration key or value that is not possible."""


class MissingArtifactError(PipelineError):
    """A stage needs what another stage has not yet written."""


class MissingPackageError(PipelineError):
    """An optional package is not installed."""


class EngineError(PipelineError):
    """An engine that cannot start, or tasks whose workers died."""


class GraspError(PipelineError):
    """A scene that cannot be built, or a robot that has none."""


class PerceptionError(PipelineError):
    """A camera that is not possible, a detector that does not fit, or an image of another kind."""


class SpeechError(PipelineError):
    """Speech that is not available here; says what is missing and how to get it."""
