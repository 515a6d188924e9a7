"""Seeds derived from what may influence a draw, and from nothing else."""

from __future__ import annotations

import hashlib


def derive_seed(root: int, *parts: str | int) -> int:
    """Return a seed in [0, 2**32) from the root seed and names such as stage, robot, repetition.

    SHA-256 makes seeds of different parts independent, and the same parts give the same seed on
    every machine and in every process.
    """
    text = "/".join(str(part) for part in (root, *parts))
    return int.from_bytes(hashlib.sha256(text.encode()).digest()[:4], "little")
