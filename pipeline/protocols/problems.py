"""What a protocol asks: targets, where each answer to them starts, and what its rows hold."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import qmc

from pipeline.data.dataset import joint_columns
from pipeline.evaluation.verification import tip_poses
from pipeline.protocols.config import ProtocolConfig
from pipeline.seeding import derive_seed
from robots.rotations import (
    matrix_from_quaternion,
    quaternion_conjugate,
    quaternion_multiply,
    rotation_vector_from_quaternion,
)

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]
MM_PER_M = 1000.0

COLUMNS = {  # beside those of pipeline.evaluation.rows
    "protocol": "name of the protocol",
    "target": "number of the target; several rows have the same where a solver draws",
    "call": "number of the call that the answer came of",
    "axis_position_error_mm": "largest distance along an axis of the target [mm]",
    "axis_rotation_error_deg": "largest component of the rotation vector, in axes of it [deg]",
    "axis_idle_position_error_mm": "the first, of the idle configuration [mm]",
    "axis_idle_rotation_error_deg": "the second, of the idle configuration [deg]",
}


@dataclass(frozen=True)
class Questions:
    """N answers that are asked for, those to one target one after the other.

    Attributes:
        poses: (N, 7) targets x y z in m, then qw qx qy qz.
        start: (N, dof) where each starts [rad or m]; None leaves it to the solver.
    """

    poses: Array
    start: Array | None

    def first(self, count: int) -> Questions:
        """Return the first so many."""
        return Questions(self.poses[:count], None if self.start is None else self.start[:count])


def questions(
    robot: Robot, protocol: ProtocolConfig, root: int, workspace_filter: bool
) -> Questions:
    """Draw the targets of a protocol and the starts; the same for every solver.

    Args:
        robot: The robot.
        protocol: Targets, starts and draws of each target.
        root: Root seed of the run.
        workspace_filter: Whether targets in the workspace lie in the robot's box.
    """
    seed = derive_seed(root, "protocol", protocol.name, robot.name)
    joints = _targets(robot, protocol, derive_seed(seed, "targets"), workspace_filter)
    poses = np.repeat(robot.forward_kinematics(joints), protocol.draws, axis=0)
    return Questions(poses, _starts(robot, protocol.start, len(poses), derive_seed(seed, "starts")))


def _targets(robot: Robot, protocol: ProtocolConfig, seed: int, workspace_filter: bool) -> Array:
    """(N, dof) configurations whose tip poses are the targets."""
    count = protocol.targets_at_most
    if protocol.targets == "workspace":
        return robot.sample(count, seed, workspace_filter=workspace_filter)
    if protocol.targets == "near_home":
        kinds = len(protocol.within_deg)
        within = np.deg2rad(protocol.within_deg)[np.arange(count) % kinds]
        offset = np.random.default_rng(seed).uniform(-1.0, 1.0, (count, robot.dof))
        return np.clip(robot.home + within[:, None] * offset, robot.lower, robot.upper)
    if protocol.targets == "halton":
        sequence = qmc.Halton(robot.dof, scramble=False)
        sequence.fast_forward(1)  # the first is the corner of all lower limits
        return np.asarray(qmc.scale(sequence.random(count), robot.lower, robot.upper))
    return robot.sample(count, seed, collision_free=protocol.targets == "free")


def _starts(robot: Robot, start: str, count: int, seed: int) -> Array | None:
    if start == "none":
        return None
    if start == "random":
        return np.random.default_rng(seed).uniform(robot.lower, robot.upper, (count, robot.dof))
    middle = (robot.lower + robot.upper) / 2.0
    return np.tile(robot.home if start == "home" else middle, (count, 1))


def with_protocol(
    rows: pd.DataFrame, asked: Questions, robot: Robot, protocol: ProtocolConfig
) -> pd.DataFrame:
    """Add the columns of `COLUMNS` to raw rows.

    Args:
        rows: Of `pipeline.evaluation.rows`, of one batch size; ``pose`` is the row of ``asked``.
        asked: What was asked.
        robot: The robot.
        protocol: The protocol.
    """
    number = rows.pose.to_numpy()
    targets = asked.poses[number]
    reached = tip_poses(robot, rows[joint_columns(robot)].to_numpy(dtype=np.float64))
    idle = tip_poses(robot, np.asarray(robot.home, dtype=np.float64)[None])
    columns = {
        "protocol": protocol.name,
        "target": number // protocol.draws,
        "call": number // rows.batch_size.to_numpy(),
    }
    for kind, poses in (("", reached), ("idle_", np.repeat(idle, len(rows), axis=0))):
        position, rotation = axis_errors(targets, poses)
        columns[f"axis_{kind}position_error_mm"] = position
        columns[f"axis_{kind}rotation_error_deg"] = rotation
    return rows.assign(**columns)


def axis_errors(targets: Array, reached: Array) -> tuple[Array, Array]:
    """Return the largest error of any axis, in axes of the target, as TRAC-IK judges.

    Args:
        targets: (N, 7) poses x y z in m, then qw qx qy qz.
        reached: (N, 7) poses in the same frame.

    Returns:
        (N,) largest distance along an axis [mm], and (N,) largest component of the rotation vector
        [deg].
    """
    turned = matrix_from_quaternion(targets[:, 3:])
    offset = np.einsum("nji,nj->ni", turned, reached[:, :3] - targets[:, :3])
    between = quaternion_multiply(quaternion_conjugate(targets[:, 3:]), reached[:, 3:])
    angle = rotation_vector_from_quaternion(between)
    return np.abs(offset).max(axis=1) * MM_PER_M, np.rad2deg(np.abs(angle).max(axis=1))
