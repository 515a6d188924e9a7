"""Progress bars and log lines: to stderr, so that stdout is a stage's result and nothing else."""

from __future__ import annotations

import logging
import sys
from pathlib import Path
from typing import Any

from tqdm import tqdm

LOGGER = logging.getLogger("cycleik_bench")
_hidden = False


class _StandardError(logging.StreamHandler):  # type: ignore[type-arg]
    """Writes to what is standard error when a line comes: it may have been replaced since."""

    @property
    def stream(self) -> Any:
        """Where lines go."""
        return sys.stderr

    @stream.setter
    def stream(self, value: Any) -> None:
        """Keep nothing: the base class sets it when it is made."""


def set_up_logging() -> None:
    """Send log lines to stderr, once."""
    if not LOGGER.handlers:
        handler = _StandardError()
        handler.setFormatter(logging.Formatter("%(message)s"))
        LOGGER.addHandler(handler)
        LOGGER.setLevel(logging.INFO)
        LOGGER.propagate = False


def last_line(log: Path) -> str:
    """Return the last line of a log that is not blank: why a command failed; empty without one."""
    text = log.read_text(encoding="utf-8", errors="replace") if log.exists() else ""
    return next((line for line in reversed(text.splitlines()) if line.strip()), "")


def hide_bars() -> None:
    """Draw no bars in this process: it is a worker, and its parent draws one for all."""
    global _hidden
    _hidden = True


def bar(total: int, unit: str, description: str, initial: int = 0) -> Any:
    """Return a tqdm bar on stderr that redraws rarely when stderr is a file."""
    interval = 0.2 if sys.stderr.isatty() else 10.0
    return tqdm(
        total=total,
        initial=initial,
        unit=unit,
        desc=description,
        mininterval=interval,
        file=sys.stderr,
        dynamic_ncols=True,
        disable=_hidden,
    )
