"""Progress bars and log lines: to stderr, so that stdout is a stage's result and nothing else."""

from __future__ import annotations

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from tqdm import tqdm

LOGGER = logging.getLogger("cycleik_bench")
_hidden = False


class _StandardError(logging.StreamHandler):  # type: ignore[type-arg]
    """Writes to what is standard error when a line comes: it may have been replaced since."""

    def emit(self, record: logging.LogRecord) -> None:
        """Write a line, above the bars that are drawn there."""
        with tqdm.external_write_mode(file=sys.stderr):
            super().emit(record)

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
        handler.setLevel(logging.INFO)
        handler.setFormatter(logging.Formatter("%(message)s"))
        LOGGER.addHandler(handler)
        LOGGER.setLevel(logging.INFO)
        LOGGER.propagate = False


class _LogFile(logging.FileHandler):
    def handleError(self, record: logging.LogRecord) -> None:  # noqa: N802 - logging's name
        """Let a line be missing: a full disk is reported by the task that fills it."""


@contextmanager
def log_file(path: Path) -> Iterator[None]:
    """Write lines to a file as well, with their times, and those of level DEBUG to it alone."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handler = _LogFile(path, mode="w", encoding="utf-8")
    handler.setFormatter(logging.Formatter("%(asctime)s %(message)s", "%Y-%m-%d %H:%M:%S"))
    level = LOGGER.level
    LOGGER.addHandler(handler)
    LOGGER.setLevel(logging.DEBUG)
    LOGGER.info("logs: %s", path.parent)
    try:
        yield
    finally:
        LOGGER.removeHandler(handler)
        LOGGER.setLevel(level)
        handler.close()


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


class WholeBar:
    """One bar for much that takes long: the share of time that is behind, and a text.

    It is redrawn on a terminal; elsewhere a line comes for each tenth.
    """

    TENTHS = 10

    def __init__(self) -> None:
        """Draw nothing yet."""
        self._tenth = 0
        self._bar = tqdm(
            total=1.0,
            bar_format="{percentage:3.0f}% |{bar:20}| {desc}",
            file=sys.stderr,
            dynamic_ncols=True,
            leave=False,
            disable=not sys.stderr.isatty(),
        )

    def show(self, share: float, text: str) -> None:
        """Say how far it is.

        Args:
            share: From 0 to 1; the bar does not go back where more is left than was thought.
            text: How many are done and what is left.
        """
        self._bar.set_description_str(text, refresh=False)
        self._bar.n = max(self._bar.n, min(share, 1.0))
        self._bar.refresh()
        tenth = int(share * self.TENTHS)
        if self._bar.disable and self._tenth < tenth:
            LOGGER.info("%3d %%  %s", self.TENTHS * tenth, text)
            self._tenth = tenth

    def close(self) -> None:
        """Take the bar away."""
        self._bar.close()
