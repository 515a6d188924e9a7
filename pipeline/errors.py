"""Errors that a user can mend: the command line prints them as one line and exits with 2."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class PipelineError(ValueError):
    """Bad input, said in a sentence that names what was expected and what to do."""


class ConfigError(PipelineError):
    """A configuration key or value that cannot be."""


class MissingArtifactError(PipelineError):
    """A stage needs what another stage has not yet written."""


def choices(kind: str, name: str, valid: Iterable[str]) -> str:
    """Say that ``name`` is no ``kind``, which one is meant perhaps, and which there are."""
    names = sorted(valid)
    close = difflib.get_close_matches(name, names, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else "."
    return f"there is no {kind} '{name}'{hint} Valid: {', '.join(names)}"
