"""The transcript of a run: every message with its result, as JSON lines."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from pipeline.agent.action import Action
from pipeline.data.files import replacing


class Transcript:
    """Entries in order: role, text, actions, problem, time (UTC).

    Attributes:
        entries: The entries, ready for JSON.
    """

    def __init__(self, clock: Callable[[], datetime] = lambda: datetime.now(UTC)) -> None:
        self.entries: list[dict[str, Any]] = []
        self._clock = clock

    def add(self, role: str, text: str, actions: Sequence[Action] = (), problem: str = "") -> None:
        """Add an entry.

        Args:
            role: system, user, assistant or body.
            text: What was said; a reply as the model gave it.
            actions: What it requests.
            problem: Reason code and sentence, or nothing.
        """
        self.entries.append(
            {
                "role": role,
                "text": text,
                "actions": [asdict(action) for action in actions],
                "problem": problem,
                "time": self._clock().isoformat(timespec="milliseconds"),
            }
        )


def write_transcript(path: Path, entries: Iterable[dict[str, Any]]) -> None:
    """Write entries as JSON lines, atomically; half a surrogate pair becomes an escape."""
    lines = [json.dumps(entry, ensure_ascii=True, sort_keys=True) for entry in entries]
    with replacing(path) as partial:
        partial.write_text("".join(line + "\n" for line in lines), encoding="utf-8")


def read_transcript(path: Path) -> list[dict[str, Any]]:
    """Return the entries of a transcript."""
    lines = path.read_text(encoding="utf-8").splitlines()
    return [json.loads(line) for line in lines if line]
