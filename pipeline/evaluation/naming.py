"""How a solver is called in raw rows: its own name, and what sets its rows apart."""

from __future__ import annotations

UNPINNED = "_unpinned"  # ends the name of a solver in rows that were not measured on pinned cores


def row_name(solver: str, pinned: bool) -> str:
    """Return the name of a solver in the rows: one that used all cores is a solver of its own."""
    return solver if pinned else f"{solver}{UNPINNED}"


def solver_of_rows(name: str) -> str:
    """Return the solver behind a name in the rows."""
    return name.removesuffix(UNPINNED)
