"""Committed boards: one CSV a machine, suite and robot, one line a solver."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.artifacts import exclusive
from pipeline.data.files import write_text
from pipeline.leaderboard.errors import LeaderboardError
from pipeline.leaderboard.schema import BOARD, checked, limits_of, read_lines
from pipeline.presentation.naming import ordered_solvers


def machine_name(processor: str, threads: int) -> str:
    """Return a plain word for a machine, such as ``amd_epyc_7543_1_thread``."""
    plain = re.sub(r"\([^)]*\)|[^A-Za-z0-9]+", " ", processor).lower().split()
    kept = [word for word in plain if word not in ("processor", "cpu", "core", "with")]
    return "_".join([*kept, str(threads), "thread" if threads == 1 else "threads"])


def board_path(folder: Path, machine: str, suite: str, robot: str) -> Path:
    """Return the file of a board."""
    return folder / machine / f"{suite}_{robot}.csv"


def put(folder: Path, machine: str, line: Mapping[str, Any]) -> Path:
    """Add a line to its board, in place of an earlier one of the same solver.

    Args:
        folder: ``results/leaderboard``.
        machine: Name of the machine, a folder there.
        line: Values by column.

    Returns:
        The file.

    Raises:
        LeaderboardError: The line is not as it should be, the board is of another version or size
            of the suite or was judged by other tolerances, or the machine's folder has lines of
            another processor.
    """
    path = board_path(folder, machine, str(line["suite"]), str(line["robot"]))
    fresh = pd.DataFrame([{key: _text(value) for key, value in line.items()}])
    checked(fresh, path)
    _check_processor(folder / machine, str(line["processor"]))
    with exclusive(path):  # two that add at once would lose the line of one
        texts = _with_others(fresh, path) if path.exists() else fresh
        order = ordered_solvers(texts.solver)
        texts = texts.sort_values("solver", key=lambda names: names.map(order.index))
        checked(texts, path)
        write_text(path, texts.to_csv(index=False, lineterminator="\n"))
    return path


def _with_others(fresh: pd.DataFrame, path: Path) -> pd.DataFrame:
    """A line behind those of the other solvers of its board, as texts."""
    read_lines(path)
    former = pd.read_csv(path, dtype=str, keep_default_na=False)
    _check_same(former, fresh, path)
    others = former[former.solver != fresh.solver.iloc[0]]
    return pd.concat([others, fresh], ignore_index=True)


def read_boards(folder: Path) -> pd.DataFrame:
    """Read every line below a folder; empty where there is none.

    Raises:
        LeaderboardError: A file there is not as it should be.
    """
    found = [read_lines(path) for path in sorted(folder.glob("*/*.csv"))]
    return pd.concat(found, ignore_index=True) if found else pd.DataFrame()


def _check_same(former: pd.DataFrame, fresh: pd.DataFrame, path: Path) -> None:
    for name in BOARD:
        ours, theirs = former[name].iloc[0], fresh[name].iloc[0]
        if ours != theirs:
            raise LeaderboardError(
                f"{path} is of {name} {ours}, this file of {theirs}: answer the suite of the same "
                "version, profile and seed with the same keys, or remove the board to begin a new "
                "one"
            )
    ours, theirs = (", ".join(limits_of(lines)) for lines in (former, fresh))
    if ours != theirs:
        raise LeaderboardError(
            f"{path} has {ours}, this file {theirs}: take the same report.leaderboard.within_us, "
            "or remove the board to begin a new one"
        )


def _check_processor(folder: Path, processor: str) -> None:
    """Refuse to call two processors one machine: times of one board are compared."""
    for path in sorted(folder.glob("*.csv")):
        other = read_lines(path).processor.iloc[0]
        if other != processor:
            raise LeaderboardError(
                f"{folder} has lines of {other}, and this is of {processor}: choose another "
                "--machine"
            )


def _text(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
