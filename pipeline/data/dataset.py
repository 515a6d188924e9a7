"""The pose sets of a robot: made once, checked whenever they are read."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.data.files import read_json, sha256, write_sealed_json
from pipeline.data.tables import TableError, read_table, write_table
from pipeline.seeding import derive_seed
from robots import Robot
from robots.checksums import sampling_checksum

POSE_COLUMNS = ("x", "y", "z", "qw", "qx", "qy", "qz")
CARD = "card.json"


class DatasetError(ValueError):
    """A pose set is missing, damaged, or was made for something else."""


@dataclass(frozen=True)
class PoseSet:
    """Reachable poses of a robot and the joints that they were made from.

    Attributes:
        poses: (N, 7) x y z in metres, then the unit quaternion, scalar first, w >= 0.
        joints: (N, dof) radians or metres, collision-free.
    """

    poses: NDArray[np.float64]
    joints: NDArray[np.float64]

    def first(self, count: int) -> PoseSet:
        """Return its first poses, all of them for 0."""
        return PoseSet(self.poses[: count or None], self.joints[: count or None])


def split_seed(root: int, robot: str, split: str) -> int:
    """Return the seed of one split; splits of one robot are independent."""
    return derive_seed(root, "dataset", robot, split)


def write_split(
    path: Path, robot: Robot, joints: NDArray[np.float64], facts: dict[str, Any]
) -> None:
    """Write the poses of joints (N, dof) as one Parquet file, atomically.

    Args:
        path: The Parquet file.
        robot: Gives the poses.
        joints: (N, dof) radians or metres.
        facts: Provenance for the schema: seed, URDF checksum, filters.
    """
    poses = robot.forward_kinematics(joints)
    frame = pd.DataFrame(np.hstack((poses, joints)), columns=[*POSE_COLUMNS, *joint_columns(robot)])
    write_table(path, frame, facts)


def joint_columns(robot: Robot) -> list[str]:
    """Return the columns that hold joint values, base to tip: q0, q1 and so on."""
    return [f"q{index}" for index in range(robot.dof)]


def write_card(folder: Path, card: dict[str, Any], splits: Sequence[str]) -> None:
    """Write the card of a folder of splits with the checksum of each file; it completes the set."""
    files = {f"{split}.parquet": sha256(folder / f"{split}.parquet") for split in splits}
    write_sealed_json(folder / CARD, {**card, "files": files})


def read_split(folder: Path, split: str, robot: Robot) -> PoseSet:
    """Read one split and check that it is whole and belongs to this robot.

    Args:
        folder: Folder of a robot's pose sets.
        split: ``train``, ``validation`` or ``test``.
        robot: The robot it must have been made for.

    Raises:
        DatasetError: It is missing, cut off, edited, or of another robot or URDF.
    """
    remake = f"make it again with: python -m pipeline dataset robot={robot.name}"
    try:
        card = read_json(folder / CARD)
        if card.get("checksum") != sampling_checksum(robot):
            raise DatasetError(
                f"{folder} was made from another description (URDF or robot.yaml) of "
                f"{robot.name}; {remake}"
            )
        path = folder / f"{split}.parquet"
        frame = read_table(path, [*POSE_COLUMNS, *joint_columns(robot)])
        if card.get("files", {}).get(path.name) != sha256(path):
            raise DatasetError(f"{path} is not the file that {folder / CARD} speaks of; {remake}")
    except FileNotFoundError as error:
        raise DatasetError(f"there is no {error.filename}; {remake}") from error
    except TableError as error:
        raise DatasetError(f"{error} ({remake})") from error
    values = frame.to_numpy(dtype=np.float64)
    return PoseSet(poses=values[:, :7].copy(), joints=values[:, 7:].copy())


def card_config(folder: Path) -> dict[str, Any]:
    """Return the configuration that a folder of splits was made with; empty where there is none."""
    path = folder / CARD
    return dict(read_json(path).get("config", {})) if path.exists() else {}
