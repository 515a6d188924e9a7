"""Packages of the extras, imported where an engine is used and missed in one sentence."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from pipeline.engine.errors import EngineError


def package(name: str, extra: str) -> Any:
    """Import a module of an optional package.

    Args:
        name: Of the module.
        extra: Extra of this project that brings the package.

    Raises:
        EngineError: It is not installed.
    """
    try:
        return import_module(name)
    except ImportError as error:
        top = name.split(".")[0]
        raise EngineError(
            f"this engine needs the package {top}, which cannot be imported ({error}); install "
            f"it with: pip install 'cycleik-bench[{extra}]'"
        ) from error
