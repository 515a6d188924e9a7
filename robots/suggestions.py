"""The sentence about a name that does not exist: what may have been meant, and what there is."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def unknown_name(kind: str, name: str, valid: Iterable[str]) -> str:
    """Say that there is no ``kind`` of that name, which one may be meant, and which exist.

    Args:
        kind: What the name would be of, such as ``robot``.
        name: As it was given.
        valid: Names that exist.

    Returns:
        One sentence.
    """
    names = sorted(valid)
    close = difflib.get_close_matches(name, names, n=1)
    hint = f"; did you mean '{close[0]}'?" if close else "."
    return f"there is no {kind} '{name}'{hint} Valid: {', '.join(names)}"
