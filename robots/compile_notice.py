"""A line on stderr while kernels are compiled, which otherwise looks as if nothing happened.

Numba fires its event only where it compiles: a kernel that it finds on disk costs no line. The
first line comes after a second, so that a small function goes by without one.
"""

from __future__ import annotations

import os
import sys
import time
from typing import Any

from numba.core import event

OURS = ("robots", "baselines", "pipeline")
EVENT = "numba:compile"
PATIENCE_S = 1.0


class CompileNotice(event.Listener):
    """Says that a kernel is compiled, and on a terminal how far that has come.

    Attributes:
        silent: Whether to say nothing.
    """

    def __init__(self) -> None:
        self.silent = False
        self._process = os.getpid()
        self._depth, self._functions, self._begin = 0, 0, 0.0
        self._said = False  # of the kernel that is being compiled
        self._introduced = False  # in this process

    def on_start(self, event: Any) -> None:
        """Count functions inside functions; the outermost is the kernel that somebody called."""
        if self._depth == 0:
            if not _is_ours(event):
                return
            self._functions, self._begin, self._said = 0, time.monotonic(), False
        self._depth += 1
        self._say(event)

    def on_end(self, event: Any) -> None:
        """Renew the line, and end it with the kernel."""
        if self._depth == 0:
            return
        self._depth -= 1
        self._functions += 1
        self._say(event)
        if self._depth == 0 and self._said and sys.stderr.isatty():
            print(file=sys.stderr)

    def _say(self, event: Any) -> None:
        spent = time.monotonic() - self._begin
        if self.silent or spent < PATIENCE_S or os.getpid() != self._process:  # or a forked worker
            return
        if sys.stderr.isatty():
            text = f"\rcompiling kernels, once: {self._functions} functions, {spent:.0f} s "
            print(text, end="", file=sys.stderr, flush=True)
        elif not self._introduced:
            print("compiling kernels, once: some seconds each", file=sys.stderr, flush=True)
        self._said = self._introduced = True


def _is_ours(event: Any) -> bool:
    function = event.data["dispatcher"].py_func
    return str(function.__module__).partition(".")[0] in OURS


_notice: CompileNotice | None = None


def announce_compiling() -> None:
    """Let a line on stderr say it whenever this process compiles kernels."""
    global _notice
    if _notice is None:
        _notice = CompileNotice()
        event.register(EVENT, _notice)


def stay_silent() -> None:
    """Say nothing in this process: it is a worker, and its parent says it for all."""
    announce_compiling()
    assert _notice is not None
    _notice.silent = True
