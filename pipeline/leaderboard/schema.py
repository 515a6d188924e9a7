"""A committed line: its columns, what they mean, and what cannot be."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import pandas as pd

from pipeline.leaderboard.errors import LeaderboardError

WITHIN = re.compile(r"within_(\d+(?:\.\d+)?)us")
HERE, SENT = "here", "sender"  # who measured the times
WORD = re.compile(r"[A-Za-z0-9][\w.-]*")


@dataclass(frozen=True)
class Field:
    """A column of a line.

    Attributes:
        meaning: With its unit.
        check: Says of a text what it should be instead; None where it is right.
        optional: It may be empty.
    """

    meaning: str
    check: Callable[[str], str | None]
    optional: bool = False


def _matches(pattern: str, wanted: str) -> Callable[[str], str | None]:
    return lambda text: None if re.fullmatch(pattern, text) else wanted


@dataclass(frozen=True)
class _Whole:
    """Check of a whole number, which its column is converted to."""

    low: int

    def __call__(self, text: str) -> str | None:
        fits = re.fullmatch(r"\d+", text) and int(text) >= self.low
        return None if fits else f"a whole number from {self.low}"


def _number(text: str) -> str | None:
    try:
        return None if 0 <= float(text) < float("inf") else "a finite number from 0"
    except ValueError:
        return "a number"


def _day(text: str) -> str | None:
    try:
        date.fromisoformat(text)
    except ValueError:
        return "a day, such as 2026-01-31"
    return None


TEXT = _matches(r"\S(.*\S)?", "a text")
FIELDS = {
    "suite": Field("name of the suite, of conf/suite", _matches(r"[a-z]\w*", "a plain word")),
    "suite_version": Field("its version", _Whole(1)),
    "suite_checksum": Field("SHA-256 of its content", _matches(r"[0-9a-f]{64}", "64 hex digits")),
    "robot": Field("name of the robot", _matches(r"[a-z]\w*", "a plain word")),
    "robot_source": Field(
        "package, version and file of a robot that does not come with this project, base and tip",
        TEXT,
        optional=True,
    ),
    "profile": Field("of conf/profile, which sets the size of the suite", TEXT),
    "seed": Field("root seed of the suite", _Whole(0)),
    "solver": Field("how it is called", _matches(r"\w[\w.@:+-]*", "letters, digits and ._-@:+")),
    "versions": Field("of what it runs on, such as `numpy 2.3.5, pin 3.8.0`", TEXT),
    "network": Field("model and recipe behind a neural one", TEXT, optional=True),
    "processor": Field("that it ran on, an accelerator behind it", TEXT),
    "threads": Field("cores that it was allowed", _Whole(1)),
    "batch_size": Field("poses a call; only with 1 there are times", _Whole(1)),
    "timed_by": Field(f"`{HERE}`: by this pipeline; `{SENT}`", _matches(f"{HERE}|{SENT}", HERE)),
    "date": Field("day on which it ran, UTC", _day),
    "commit": Field("of the code that ran it, or the sender's version of theirs", TEXT),
    "answers_sha256": Field("of the file of answers", _matches(r"[0-9a-f]{64}", "64 hex digits")),
    "criterion": Field("what is counted: solved, true no, followed, reached and free", TEXT),
    "position_mm": Field("tolerance of a solved pose, exclusive [mm]", _number),
    "rotation_deg": Field("the same for its rotation [deg]", _number),
    "trials": Field(
        "what is counted: poses, or trajectories, of which the first ones may be answered alone",
        _Whole(1),
    ),
    "good": Field("how many of them meet the criterion", _Whole(0)),
    "poses": Field("poses of the suite, or of those trajectories", _Whole(1)),
    "good_poses": Field("how many of these are solved, or rightly denied", _Whole(0)),
    "position_mean_mm": Field("mean position error of all answers [mm]", _number),
    "position_median_mm": Field("median of the same [mm]", _number),
    "position_p99_mm": Field("99th percentile of the same [mm]", _number),
    "rotation_mean_deg": Field("mean rotation error of all answers [deg]", _number),
    "rotation_median_deg": Field("median of the same [deg]", _number),
    "rotation_p99_deg": Field("99th percentile of the same [deg]", _number),
    "claimed_and_wrong": Field("poses called solved that are not", _Whole(0)),
    "outside_limits": Field("poses answered with joints outside their limits", _Whole(0)),
    "self_colliding": Field("solved poses whose joints let the robot touch itself", _Whole(0)),
    "shift_us": Field("shift of the geometric mean of times [us]", _number, optional=True),
    "time_geometric_us": Field(
        "shifted geometric mean of the time of a call, misses as long as they took [us]",
        _number,
        optional=True,
    ),
    "time_median_us": Field("median time of a call [us]", _number, optional=True),
    "time_p99_us": Field("99th percentile of the same [us]", _number, optional=True),
}
BOARD = (  # one value in all lines of a board
    "suite_version",
    "suite_checksum",
    "seed",
    "criterion",
    "position_mm",
    "rotation_deg",
)
COUNTED = {  # a count and what it is part of
    "good": "trials",
    "good_poses": "poses",
    "claimed_and_wrong": "poses",
    "outside_limits": "poses",
    "self_colliding": "good_poses",
}


def within_name(limit_us: float) -> str:
    """Return the column that says how many poses are solved by calls of at most so long [us]."""
    return f"within_{limit_us:.12g}us"


def read_lines(path: Path) -> pd.DataFrame:
    """Read a committed file and check every cell of it.

    Returns:
        Its lines, numbers as numbers, with a column ``machine``: the name of its folder.

    Raises:
        LeaderboardError: What is not as `FIELDS` says, with line and column.
    """
    try:
        texts = pd.read_csv(path, dtype=str, keep_default_na=False)
    except (OSError, ValueError) as error:
        raise LeaderboardError(f"{path} is not readable as CSV ({error})") from error
    return checked(texts, path)


def limits_of(lines: pd.DataFrame) -> list[str]:
    """Return the columns of the success profile, see `within_name`."""
    return [str(name) for name in lines if WITHIN.fullmatch(str(name))]


def checked(texts: pd.DataFrame, path: Path) -> pd.DataFrame:
    """Check the cells of a board, as texts, and return its lines, see `read_lines`."""
    limits = limits_of(texts)
    wanted, given = [*FIELDS, *limits], [str(name) for name in texts]
    if given != wanted:
        odd = sorted(set(FIELDS) ^ (set(given) - set(limits))) or ["their order"]
        raise LeaderboardError(f"{path}: expected the columns of FIELDS, differing: {odd}")
    for number, line in enumerate(texts.to_dict("records"), start=2):
        wrong = _wrong(line, limits)
        if wrong:
            raise LeaderboardError(f"{path}, line {number}: {wrong}")
    _check_board(texts, path)
    return _typed(texts, limits).assign(machine=path.parent.name)


def _wrong(line: dict[Any, str], limits: list[str]) -> str | None:
    """What is wrong with a line, None where nothing is."""
    for name, field in FIELDS.items():
        text = line[name]
        wanted = field.check(text) if text or not field.optional else None
        if wanted:
            return f"{name} must be {wanted}, got {text!r}"
    for part, whole in COUNTED.items():
        if int(line[part]) > int(line[whole]):
            return f"{part} is {line[part]}, more than {whole}, {line[whole]}"
    timed = [bool(line[name]) for name in ("time_geometric_us", "time_median_us", *limits)]
    if any(timed) != all(timed):
        return "some of its times are missing"
    counts = [line[name] for name in limits if line[name]]
    if any(not text.isdigit() for text in counts):
        return "within_..us must be whole numbers"
    rising = [*map(int, counts), int(line["good_poses"])]
    return None if rising == sorted(rising) else "within_..us must rise, up to good_poses"


def _check_board(texts: pd.DataFrame, path: Path) -> None:
    """Refuse lines that are not of one board, or not of the one that the file is named for."""
    for name in BOARD:
        if texts[name].nunique() > 1:
            raise LeaderboardError(f"{path}: {name} differs between lines, which no rank survives")
    if texts.shift_us[texts.shift_us != ""].nunique() > 1:
        raise LeaderboardError(f"{path}: shift_us differs between lines, so that no time compares")
    named = {f"{line.suite}_{line.robot}.csv" for line in texts.itertuples()}
    if named != {path.name}:
        raise LeaderboardError(f"{path}: its lines are those of {', '.join(sorted(named))}")
    twice = texts.solver[texts.solver.duplicated()].tolist()
    if twice:
        raise LeaderboardError(f"{path} has {twice[0]} twice")
    if not WORD.fullmatch(path.parent.name):
        raise LeaderboardError(f"{path}: the folder's name, of a machine, must be a plain word")


def _typed(texts: pd.DataFrame, limits: list[str]) -> pd.DataFrame:
    numeric = [n for n, field in FIELDS.items() if field.check is _number] + limits
    counts = [n for n, field in FIELDS.items() if isinstance(field.check, _Whole)]
    typed = {n: pd.to_numeric(texts[n].mask(texts[n] == "")).astype(float) for n in numeric}
    return texts.assign(**typed, **{n: texts[n].astype(int) for n in counts})
