"""A file that somebody sends: raw rows of this pipeline, or answers beside a YAML file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pipeline.data.files import read_yaml
from pipeline.data.tables import TableError, read_metadata, read_table
from pipeline.leaderboard.errors import LeaderboardError
from pipeline.leaderboard.schema import FIELDS, HERE, SENT
from pipeline.suites.judging import read_answers

SIDECAR = {
    "solver": "how it is called",
    "robot": "of conf/robot",
    "suite": "of conf/suite",
    "profile": "of conf/profile, which sets the size of the suite",
    "seed": "root seed of the suite, 0 if you did not set one",
    "versions": "what it runs on: names and their versions",
    "commit": "of your code, or its version",
    "processor": "as /proc/cpuinfo calls it",
    "threads": "cores that the solver was allowed",
    "date": "day on which it ran, such as 2026-01-31",
}
TIME = "time_us"  # column of answers: wall time of the call with that one pose [us]
ANSWERED = "answered"  # column of raw rows; of a sender it would be a claim that nobody checks
SHOWN_VERSIONS = ("python", "numpy", "numba", "torch", "pin", "placo")


@dataclass(frozen=True)
class Submission:
    """What was sent.

    Attributes:
        path: The file.
        answers: As `pipeline.suites.judging` wants them, and times in a column of their own.
        facts: By the keys of `SIDECAR`, and what else is known of a file of this pipeline.
        timed_by: Who measured the times.
    """

    path: Path
    answers: pd.DataFrame
    facts: Mapping[str, Any]
    timed_by: str

    def overrides(self) -> list[str]:
        """Return the overrides of the run that has the suite which was answered."""
        return [f"{key}={self.facts[key]}" for key in ("robot", "suite", "profile", "seed")]


def read_submission(path: Path) -> Submission:
    """Read what was sent; nothing in it is believed but who, when, on what, and times.

    Raises:
        LeaderboardError: It is neither kind of file, or says too little about itself.
        SuiteError: It is no Parquet.
    """
    beside = path.with_suffix(".yaml")
    if beside.exists():
        facts = _sidecar(beside)
        answers = read_answers(path).drop(columns=ANSWERED, errors="ignore")
        return Submission(path, answers, facts, SENT)
    try:
        facts, rows = read_metadata(path), read_table(path)
    except TableError as error:
        raise LeaderboardError(
            f"{error}; expected raw rows of `python -m pipeline suites`, or answers with "
            f"{beside.name} beside them that says {', '.join(SIDECAR)}"
        ) from error
    return Submission(path, _answers(path, rows, facts), _facts(path, facts, rows), HERE)


def _sidecar(path: Path) -> dict[str, Any]:
    facts = read_yaml(path)
    missing = [key for key in SIDECAR if facts.get(key) in (None, "")]
    if missing:
        raise LeaderboardError(
            f"{path} does not say {', '.join(f'{key} ({SIDECAR[key]})' for key in missing)}"
        )
    versions = facts["versions"]
    if isinstance(versions, Mapping):
        versions = ", ".join(f"{name} {number}" for name, number in versions.items())
    day = facts["date"]
    day = day.isoformat() if isinstance(day, date) else day
    said = {**facts, "versions": versions, "date": day, "network": facts.get("network", "")}
    for key in SIDECAR:
        if wanted := FIELDS[key].check(str(said[key])):
            raise LeaderboardError(f"{path}: {key} must be {wanted}, got {said[key]!r}")
    return said


def _answers(path: Path, rows: pd.DataFrame, facts: Mapping[str, Any]) -> pd.DataFrame:
    """Raw rows as answers: joints, claims and times; no error of theirs is taken over."""
    if "suite_checksum" not in facts or rows.empty:
        raise LeaderboardError(f"{path} has no rows of a suite: it is of another stage")
    if ANSWERED not in rows:
        raise LeaderboardError(f"{path} holds the poses of a suite and no answers to them")
    if rows.seed.nunique() > 1 or rows.batch_size.nunique() > 1:
        raise LeaderboardError(f"{path} has rows of several seeds or batch sizes; send one each")
    joints = [name for name in rows if str(name)[0] == "q" and str(name)[1:].isdigit()]
    answers = rows[["pose", *joints, "found", ANSWERED]].assign(
        suite_checksum=facts["suite_checksum"]
    )
    one_by_one = int(rows.batch_size.iloc[0]) == 1
    return answers.assign(**{TIME: rows.time_per_pose_us}) if one_by_one else answers


def _facts(path: Path, facts: Mapping[str, Any], rows: pd.DataFrame) -> dict[str, Any]:
    wanted = ("robot", "suite", "profile", "seed", "solver", "commit", "date", "machine")
    missing = [key for key in wanted if facts.get(key) in (None, "")]
    if missing:
        raise LeaderboardError(f"{path} does not say {', '.join(missing)}; run the suite again")
    versions, machine = facts.get("versions", {}), facts["machine"]
    shown = [f"{name} {versions[name]}" for name in SHOWN_VERSIONS if name in versions]
    accelerator = machine.get("accelerator", "none")
    also = "" if accelerator == "none" else f" with {accelerator}"
    return {
        **{key: facts[key] for key in wanted if key != "machine"},
        "versions": ", ".join(shown) or "not recorded",
        "network": facts.get("network", ""),
        "processor": f"{machine.get('processor', 'unknown')}{also}",
        "threads": int(rows.threads.iloc[0]),
        "batch_size": int(rows.batch_size.iloc[0]),
    }


def times_us(answers: pd.DataFrame, count: int, path: Path) -> np.ndarray | None:
    """Return the time of every call (N,) [us], None where there is none of each pose.

    Raises:
        LeaderboardError: Times that are no numbers, or none above 0.
    """
    if TIME not in answers or len(answers) < count:
        return None
    given = answers[TIME]
    if not pd.api.types.is_numeric_dtype(given) and given.notna().any():
        raise LeaderboardError(f"{path}: {TIME} must hold numbers, got {given.dtype}")
    times = np.empty(count)
    times[answers.pose.to_numpy(dtype=int)] = given.to_numpy(dtype=float, na_value=np.nan)
    if np.isnan(times).all():
        return None
    if not (np.isfinite(times) & (times > 0)).all():
        raise LeaderboardError(f"{path}: {TIME} must be above 0 in every row, or left out")
    return times
