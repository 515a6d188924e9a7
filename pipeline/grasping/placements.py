"""Initial states of trials: what is laid where, and those that are pinned as data.

`grasp.placements=pinned` takes the places of a file that is committed, whatever the seed and the
generator say by then: runs that are compared trial by trial have begun alike. A file a robot,
`pinned/<robot>.csv`, with a line an object; `pinned/checksums.csv` has the version and the
checksum of each. `python -m benchmarks.placements` makes them.
"""

from __future__ import annotations

import io
from collections.abc import Collection, Hashable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.data.files import sha256
from pipeline.errors import GraspError
from pipeline.grasping.config import DRAWN
from robots.rounding import DECIMALS, rounded

FOLDER = Path(__file__).with_name("pinned")
CHECKSUMS = FOLDER / "checksums.csv"
SINGLE, ROW = "single", "row"  # one object on the table, or all of them on a line
TRIALS = 100  # of a robot, as in the paper


@dataclass(frozen=True)
class Setup:
    """What is laid where in one trial.

    Attributes:
        number: Number of the trial, from 0.
        row: Row of the action area, from 0 at the near side.
        name: Which object.
        place: x and y of its centre, base frame [m].
        yaw: Its rotation about the vertical [rad].
        error: Error injected into the place that the robot receives [m], shape (2,).
    """

    number: int
    row: int
    name: str
    place: tuple[float, float]
    yaw: float
    error: NDArray[np.float64]


def pinned(robot: str, protocol: str, first: int, count: int = 1) -> list[Setup]:
    """Some pinned initial states of a robot.

    Args:
        robot: Name of the robot.
        protocol: `single` or `row`; of rows the last one has all its objects, so that there may be
            a few more than `TRIALS`.
        first: Number of the first trial, from 0.
        count: How many in the order of their numbers.

    Raises:
        GraspError: The robot has none or not so many, or its file is not the one of its checksum.
    """
    own = [each for kind, each in _read(robot) if kind == protocol]
    if first + count > len(own):
        raise GraspError(
            f"{len(own)} placements are pinned for '{robot}' ({protocol}), counted from 0; there "
            f"is no {first + count - 1}: choose grasp.placements={DRAWN}"
        )
    return own[first : first + count]


def check_pinned(robot: str, objects: Collection[str], trials: int) -> None:
    """Refuse a scene or a number of trials that the pinned placements are not of.

    Args:
        robot: Name of the robot.
        objects: Names of the scene's objects.
        trials: How many are wanted.

    Raises:
        GraspError: They are others, or more.
    """
    names = {each.name for _, each in _read(robot)}
    if names != set(objects):
        raise GraspError(
            f"the pinned placements of '{robot}' are of {', '.join(sorted(names))}, and the scene "
            f"has {', '.join(sorted(objects))}: choose grasp.placements={DRAWN}"
        )
    if trials > TRIALS:
        raise GraspError(
            f"{TRIALS} placements are pinned for '{robot}', got grasp.trials={trials}: choose "
            f"fewer, or grasp.placements={DRAWN}"
        )


def pinned_version(robot: str) -> str:
    """Version and checksum of the pinned placements of a robot, for provenance.

    Raises:
        GraspError: It has none.
    """
    known = _checksums()
    if robot not in known.index:
        raise GraspError(
            f"no placements are pinned for '{robot}'; there are {', '.join(known.index)}. "
            f"Choose grasp.placements={DRAWN}"
        )
    return f"version {known.version[robot]}, {known.sha256[robot][:12]}"


def to_text(setups: Mapping[str, Iterable[Setup]]) -> str:
    """The content of a file: setups by protocol as CSV.

    Values are rounded to a nanometre and a nanoradian, as those of suites are, so that two machines
    whose sine differs in its last bit write the same file.
    """
    lines = [
        (protocol, each.number, each.row, each.name, *rounded(np.array([*each.place, each.yaw])))
        for protocol, some in setups.items()
        for each in some
    ]
    columns = ["protocol", "trial", "row", "object", "x_m", "y_m", "yaw_rad"]
    stream = io.StringIO()
    frame = pd.DataFrame(lines, columns=columns)
    frame.to_csv(stream, index=False, float_format=f"%.{DECIMALS}f", lineterminator="\n")
    return stream.getvalue()


@cache
def _read(robot: str) -> tuple[tuple[str, Setup], ...]:
    """Protocol and setup of each line of a robot's file."""
    pinned_version(robot)
    path = FOLDER / f"{robot}.csv"
    if not path.exists() or sha256(path) != _checksums().sha256[robot]:
        raise GraspError(
            f"{path} is missing or was changed; `git checkout {path}` brings it back, "
            "`python -m benchmarks.placements --write` makes a new version"
        )
    lines = pd.read_csv(path, float_precision="round_trip").to_dict("records")
    return tuple((line["protocol"], _setup(line)) for line in lines)


def _setup(line: dict[Hashable, Any]) -> Setup:
    place = (line["x_m"], line["y_m"])
    return Setup(line["trial"], line["row"], line["object"], place, line["yaw_rad"], np.zeros(2))


@cache
def _checksums() -> pd.DataFrame:
    """Version and SHA-256 of each file, by robot."""
    return pd.read_csv(CHECKSUMS, index_col="robot")
