"""The problems of a suite: poses, what is known of each, and the checksum of all of it.

Values are rounded to 1e-9 (a nanometre, a nanoradian) before they are stored. Two machines whose
sine differs in its last bit then give the same content, and so the same checksum.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines.freedom import Freedom
from pipeline.data.dataset import POSE_COLUMNS, joint_columns
from robots.rounding import rounded

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

STRATUM = "stratum"
EVIDENCE = "evidence_"  # begins columns that say how something is known; not part of the checksum
FREEDOM = ("along_x_m", "along_y_m", "along_z_m", "about_x_rad", "about_y_rad", "about_z_rad")
OBSTACLES = "obstacles"  # column of obstacles, in their plain form
START = "start_"  # begins columns of the configuration that a solver starts from
COLUMNS = {
    "x": "target in the base frame [m]; likewise y and z",
    "qw": "its orientation, a unit quaternion, scalar first; likewise qx, qy and qz",
    STRATUM: "kind of problem within the suite",
    "q0": "a configuration that solves it, base to tip: q0, q1, … [rad or m]; NaN: none is known",
    "start_q0": "where a solver starts, start_q0, start_q1, … [rad or m]; only in some suites",
    "trajectory": "number of the trajectory; only in tracking, as the two that follow",
    "step": "number of the waypoint on it; from 1 on a solver starts at its answer to the last one",
    "rate_hz": "waypoints a second",
    "along_x_m": "how far the tip may be from the target along x of its frame [m], infinite: free; "
    "likewise along y and z, and about_x_rad [rad] about the axes; only in partial",
    OBSTACLES: "boxes and spheres in the base frame and the requested clearance [m], as JSON; "
    "only in cluttered, as the next",
    "clearance_mm": "that the known configuration keeps from them [mm]",
    "evidence_…": "how it is known that a pose cannot be reached; only in unreachable",
}


@dataclass(frozen=True)
class Problems:
    """N problems, one row each.

    Attributes:
        poses: (N, 7) targets x y z in m, then qw qx qy qz.
        stratum: (N,) kind of each within the suite.
        joints: (N, dof) a configuration that solves it, NaN where none is known.
        start: (N, dof) where a solver starts; None leaves it to the solver.
        further: Other columns by name, (N,) each; those of evidence begin with `EVIDENCE`.
    """

    poses: Array
    stratum: NDArray[np.str_]
    joints: Array
    start: Array | None = None
    further: Mapping[str, NDArray[Any]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.poses)

    def at(self, rows: NDArray[Any] | slice) -> Problems:
        """Return some of the problems: flags, numbers or a slice."""
        return Problems(
            self.poses[rows],
            self.stratum[rows],
            self.joints[rows],
            None if self.start is None else self.start[rows],
            {name: values[rows] for name, values in self.further.items()},
        )


def reached(
    robot: Robot, joints: Array, stratum: str = "", start: Array | None = None, **further: Any
) -> Problems:
    """Return the problems whose solutions are known: the tip poses of configurations.

    Args:
        robot: The robot.
        joints: (N, dof) [rad or m].
        stratum: Kind of all of them.
        start: (N, dof) where a solver starts.
        **further: Other columns, (N,) each.
    """
    known = _inside(robot, joints)
    poses = rounded(robot.forward_kinematics(known)) if len(known) else np.empty((0, 7))
    begin = None if start is None else _inside(robot, start)
    return Problems(poses, np.full(len(known), stratum), known, begin, further)


def freedoms(problems: Problems) -> tuple[Freedom, ...] | None:
    """Return what each target leaves open; None where all are whole poses."""
    if FREEDOM[0] not in problems.further:
        return None
    widths = np.stack([problems.further[name] for name in FREEDOM], axis=1)
    return tuple(Freedom((*row[:3],), (*row[3:],)) for row in widths.tolist())


def joined(parts: Sequence[Problems]) -> Problems:
    """Return the problems of several parts, of the same columns, one part after the other."""
    starts = [part.start for part in parts if part.start is not None]
    return Problems(
        np.concatenate([part.poses for part in parts]),
        np.concatenate([part.stratum for part in parts]),
        np.concatenate([part.joints for part in parts]),
        np.concatenate(starts) if starts else None,
        {name: np.concatenate([part.further[name] for part in parts]) for name in parts[0].further},
    )


def in_turns(parts: Sequence[Problems]) -> Problems:
    """Return the problems of several parts in turns, so that the first ones hold all kinds."""
    place = np.concatenate([np.arange(len(part)) for part in parts])
    return joined(parts).at(np.argsort(place, kind="stable"))


def to_frame(problems: Problems, robot: Robot) -> pd.DataFrame:
    """Return problems as the columns of `COLUMNS`."""
    columns: dict[str, Any] = dict(zip(POSE_COLUMNS, problems.poses.T, strict=True))
    columns[STRATUM] = problems.stratum
    columns |= dict(zip(joint_columns(robot), problems.joints.T, strict=True))
    if problems.start is not None:
        names = [f"{START}{name}" for name in joint_columns(robot)]
        columns |= dict(zip(names, problems.start.T, strict=True))
    return pd.DataFrame(columns | dict(problems.further))


def from_frame(frame: pd.DataFrame, robot: Robot) -> Problems:
    """Return the problems of a table that `to_frame` made."""
    joints = joint_columns(robot)
    begin = [f"{START}{name}" for name in joints]
    started = begin[0] in frame
    known = {*POSE_COLUMNS, STRATUM, *joints, *begin}
    return Problems(
        frame[list(POSE_COLUMNS)].to_numpy(dtype=np.float64),
        frame[STRATUM].to_numpy(dtype=np.str_),
        frame[joints].to_numpy(dtype=np.float64),
        frame[begin].to_numpy(dtype=np.float64) if started else None,
        {str(name): frame[name].to_numpy() for name in frame if name not in known},
    )


def checksum(frame: pd.DataFrame) -> str:
    """Return the SHA-256 of names and values of all columns but those of evidence.

    What a search met on the way to a "no" is evidence: its last digits hang on the machine.
    """
    digest = hashlib.sha256()
    for name in frame:
        if str(name).startswith(EVIDENCE):
            continue
        values = frame[name].to_numpy()
        digest.update(f"{name}:{len(values)}:".encode())
        if values.dtype.kind in "fiu":
            number = values.astype("<f8")
            digest.update(np.where(np.isnan(number), np.nan, number).tobytes())
        else:
            digest.update("\n".join(map(str, values)).encode())
    return digest.hexdigest()


def _inside(robot: Robot, joints: Array) -> Array:
    """Joints as they are stored: rounded, which may not carry them over their limits."""
    stored = rounded(joints)
    return np.where(robot.endless, stored, np.clip(stored, robot.lower, robot.upper))
