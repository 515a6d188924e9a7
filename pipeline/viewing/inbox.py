"""What callbacks of the page want done, for the one thread that does it."""

from __future__ import annotations

import threading
from collections.abc import Callable

Action = Callable[[], object]


class Inbox:
    """Actions by what they are about; of several about the same the last one counts.

    A target that is dragged sends more poses than solvers and drawing can follow.
    """

    def __init__(self) -> None:
        self._actions: dict[str, Action] = {}
        self._lock = threading.Lock()
        self._come = threading.Event()

    def post(self, about: str, action: Action) -> None:
        """Leave an action, in place of one that was left about the same and is not yet taken."""
        with self._lock:
            self._actions.pop(about, None)
            self._actions[about] = action
            self._come.set()

    def take(self, patience_s: float) -> list[Action]:
        """Wait for actions and take them, oldest first; none where none came in time."""
        self._come.wait(patience_s)
        with self._lock:
            actions = list(self._actions.values())
            self._actions.clear()
            self._come.clear()
        return actions
