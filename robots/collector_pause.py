"""No collection of garbage while kernels are compiled.

Numba makes millions of objects for its types and its intermediate code and keeps most of them until
a kernel is done, so the collector goes through them again and again and frees next to nothing.
Without it a first answer comes seconds earlier (`benchmarks/start.py`), for more memory meanwhile.
"""

from __future__ import annotations

import gc
from typing import Any

from numba.core import event

from robots.compile_notice import EVENT


class CollectorPause(event.Listener):
    """Stops Python's cyclic collector from the start of a kernel until it is done.

    Numba compiles on one thread at a time, behind a lock of its own, so a count is enough to know
    the outermost function. Whoever has stopped the collector before finds it stopped.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._was_enabled = False

    def on_start(self, event: Any) -> None:
        """Stop it with the outermost function."""
        if self._depth == 0:
            self._was_enabled = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """Let it go on after the outermost function, also where that could not be compiled."""
        self._depth -= 1
        if self._depth == 0 and self._was_enabled:
            gc.enable()


_pause: CollectorPause | None = None


def pause_collector_while_compiling() -> None:
    """Pause the collector whenever this process compiles kernels."""
    global _pause
    if _pause is None:
        _pause = CollectorPause()
        event.register(EVENT, _pause)
