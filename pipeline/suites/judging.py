"""Answers to a suite that came from elsewhere: read with care, judged as any solver's are.

A file is Parquet with one row a pose and the columns of `COLUMNS`. Nothing in it is trusted: errors
are recomputed from the joints, and there is no time. Poses without a row, and rows whose joints are
not finite, count as not found.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from baselines import Solution
from pipeline.data.dataset import joint_columns
from pipeline.evaluation.rows import raw_rows
from pipeline.suites.drawing import SuiteError
from pipeline.suites.generators import Suite
from pipeline.suites.problems import freedoms
from pipeline.suites.rows import with_problems
from robots.limits import FARTHEST

if TYPE_CHECKING:
    from pipeline.evaluation.config import EvaluateConfig
    from robots import Robot

Array = NDArray[np.float64]

COLUMNS = {
    "pose": "row of the suite that is answered, from 0; each at most once",
    "suite_checksum": "of the suite that is answered, as `python -m pipeline suite` says it",
    "q0": "joints, base to tip: q0, q1, … [rad or m]",
    "found": "whether the solver claims a solution; may be left out where every row is one",
}
NO_ANSWER, NOT_FINITE = "no answer", "joints were not finite"
SUFFIX = " (re-judged)"  # ends the name of a solver whose rows came from elsewhere


@dataclass(frozen=True)
class Judged:
    """What came of a file of answers.

    Attributes:
        rows: Raw rows of all poses of the suite, times NaN.
        notes: What is wrong with answers, one sentence each.
    """

    rows: pd.DataFrame
    notes: list[str]


def judge(
    path: Path, name: str, suite: Suite, robot: Robot, config: EvaluateConfig, seed: int
) -> Judged:
    """Judge a file of answers to a suite.

    Args:
        path: Parquet with the columns of `COLUMNS`.
        name: How the solver is called in the rows.
        suite: That was answered.
        robot: The robot.
        config: Tolerance of a claim, slack of a limit.
        seed: Root seed of the suite.

    Raises:
        SuiteError: The file cannot be read, lacks columns, answers another suite, or has poses that
            the suite has not.
    """
    return judge_answers(read_answers(path), path, name, suite, robot, config, seed)


def judge_answers(
    answers: pd.DataFrame,
    path: Path,
    name: str,
    suite: Suite,
    robot: Robot,
    config: EvaluateConfig,
    seed: int,
) -> Judged:
    """Judge answers that were read before, see `judge`.

    Args:
        answers: With the columns of `COLUMNS`; others are left alone.
        path: Of the file that they came from, for messages.
        name: As of `judge`, like those that follow.
        suite: That was answered.
        robot: The robot.
        config: Of an evaluation.
        seed: Root seed of the suite.

    Raises:
        SuiteError: As `judge`.
    """
    answers = _checked(answers, path, suite, robot)
    count = len(suite.problems)
    joints = np.tile(robot.home, (count, 1))
    found = np.zeros(count, dtype=bool)
    reason = np.full(count, NO_ANSWER, dtype=object)
    given = answers[joint_columns(robot)].to_numpy(dtype=np.float64)
    finite = (np.abs(given) <= FARTHEST).all(axis=1)
    pose = answers.pose.to_numpy(dtype=np.int64)
    joints[pose[finite]] = given[finite]
    claimed = answers.found.to_numpy(dtype=bool)
    found[pose] = claimed & finite
    # A "no" needs no joints; who claims a solution has to show it.
    reason[pose] = np.where(claimed, np.where(finite, "", NOT_FINITE), "not found")
    nothing = np.full(count, np.nan)
    zeros = np.zeros(count, dtype=np.int64)
    solution = Solution(joints, found, nothing, zeros, tuple(map(str, reason)))
    left_open = freedoms(suite.problems)
    rows = raw_rows(robot, suite.problems.poses, [solution], nothing, config, False, left_open)
    rows.insert(0, "robot", robot.name)
    rows.insert(1, "solver", name)
    rows.insert(2, "seed", seed)
    rows.insert(3, "pose", np.arange(count))
    rows.insert(4, "batch_size", 1)
    rows = rows.assign(seeded_by="", seed_time_us=np.nan, threads=0, pinned=False, machine="")
    return Judged(with_problems(rows, suite, robot), _notes(rows, path))


def read_answers(path: Path) -> pd.DataFrame:
    """Read a file of answers as it is.

    Raises:
        SuiteError: There is no such file, or it is no Parquet.
    """
    if path.is_dir():
        raise SuiteError(f"{path} is a folder; name the Parquet file of answers in it")
    try:
        return pq.read_table(path).to_pandas()
    except FileNotFoundError as error:
        raise SuiteError(f"there is no {path}") from error
    except (pa.ArrowException, OSError, ValueError, KeyError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise SuiteError(f"{path} is not a readable Parquet file ({why})") from error


def _checked(frame: pd.DataFrame, path: Path, suite: Suite, robot: Robot) -> pd.DataFrame:
    """The answers, with ``found`` where it was left out, if they are to this suite."""
    wanted = ["pose", "suite_checksum", *joint_columns(robot)]
    _check_columns(path, [str(name) for name in frame], wanted, robot)
    checksums = sorted({str(value) for value in frame.suite_checksum})
    if checksums != [suite.checksum]:
        raise SuiteError(
            f"{path} answers the suite with the checksum {', '.join(checksums) or 'of no row'}, "
            f"and this is {suite.name} of {robot.name}, version {suite.version}, "
            f"{len(suite.problems)} poses, with {suite.checksum}; choose the same robot, suite, "
            "profile and seed"
        )
    if "found" not in frame:
        frame = frame.assign(found=True)
    _check_values(path, frame, wanted, len(suite.problems))
    return frame


def _check_columns(path: Path, given: list[str], wanted: list[str], robot: Robot) -> None:
    missing = [name for name in wanted if name not in given]
    if missing:
        raise SuiteError(
            f"{path} lacks the column(s) {', '.join(missing)}; expected pose, suite_checksum and "
            f"q0 to q{robot.dof - 1} of {robot.name}, found if not all are, got {', '.join(given)}"
        )
    surplus = f"q{robot.dof}"
    if surplus in given:
        raise SuiteError(f"{path} has a column {surplus}, but {robot.name} has {robot.dof} joints")


def _check_values(path: Path, frame: pd.DataFrame, wanted: list[str], count: int) -> None:
    for name in (name for name in wanted if name not in ("suite_checksum",)):
        numeric = pd.api.types.is_numeric_dtype(frame[name])
        if not numeric or pd.api.types.is_bool_dtype(frame[name]):
            raise SuiteError(f"{path}: column {name} must hold numbers, got {frame[name].dtype}")
    if not pd.api.types.is_bool_dtype(frame.found) or frame.found.isna().any():
        raise SuiteError(f"{path}: column found must hold true or false, got {frame.found.dtype}")
    pose = frame.pose.to_numpy(dtype=np.float64)
    wrong = ~((pose == np.floor(pose)) & (pose >= 0) & (pose < count))
    if wrong.any():
        row = int(np.argmax(wrong))
        raise SuiteError(
            f"{path}: row {row} is for pose {pose[row]:g}; the suite has poses 0 to {count - 1}"
        )
    twice = frame.pose.duplicated().to_numpy()
    if twice.any():
        raise SuiteError(f"{path} answers pose {int(pose[np.argmax(twice)])} twice")


def _notes(rows: pd.DataFrame, path: Path) -> list[str]:
    """What is wrong with answers that are judged all the same."""
    kinds: dict[str, Any] = {
        "have no answer": rows.reason == NO_ANSWER,
        "have joints that are not finite": rows.reason == NOT_FINITE,
        "have joints outside their limits": ~rows.within_limits,
        "are claimed but wrong": rows.claimed_and_wrong,
    }
    return [
        f"{path.name}: {int(wrong.sum())} of {len(rows)} poses {what}, the first is pose "
        f"{int(np.argmax(wrong))}."
        for what, wrong in kinds.items()
        if wrong.any()
    ]
