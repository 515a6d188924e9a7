"""The raw rows: one per pose, solver, seed and batch size; the only truth that is stored."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines.freedom import Freedom, nearest_allowed, widths_of
from pipeline.evaluation.metrics import PoseErrors, pose_errors
from pipeline.evaluation.verification import self_collisions, tip_poses, within_limits

if TYPE_CHECKING:
    from baselines import Solution
    from pipeline.evaluation.config import EvaluateConfig
    from robots import Robot

Array = NDArray[np.float64]
US_PER_S = 1e6

COLUMNS = {
    "robot": "name of the robot",
    "solver": "name of the solver",
    "seed": "seed of the solver, or of the training behind it",
    "pose": "row of the pose in the test set",
    "batch_size": "poses handed over in one call (the last call of a set may hold fewer)",
    "found": "the solver's own claim to have met its tolerance",
    "answered": "found, or of a solver whose every answer counts; else the not-found policy rules",
    "reason": "why there is no solution; empty where found",
    "position_error_mm": "Euclidean distance of the returned joints' tip from the target [mm]",
    "rotation_error_deg": "geodesic angle between them [deg]",
    "paper_position_error_mm": "mean of |dx|, |dy|, |dz| [mm]",
    "paper_rotation_error_deg": "mean of the three absolute zyx Euler angles [deg]",
    "idle_position_error_mm": "position error of the idle configuration [mm]",
    "idle_rotation_error_deg": "rotation error of the idle configuration [deg]",
    "paper_idle_position_error_mm": "the same, mean over the axes [mm]",
    "paper_idle_rotation_error_deg": "the same, mean over the axes [deg]",
    "within_limits": "every joint within its limits, rounding aside",
    "self_collision": "whether the robot hits itself; none where its shapes cannot be used",
    "claimed_and_wrong": "claimed found, but beyond the claim's tolerance or a joint limit",
    "time_per_pose_us": "wall time of the call, shared out over its poses [us]",
    "solver_time_us": "the solver's own clock, per pose [us]",
    "iterations": "iterations, summed over restarts",
    "seeded_by": "where the initial guess came from: home, or the solver that gave it",
    "seed_time_us": "wall time of the call that gave it, per pose, not in time_per_pose_us [us]",
    "target_x_m": "position of the target in the base frame [m]; likewise y and z",
    "q0": "returned joints, base to tip: q0, q1, … [rad or m]",
    "threads": "cores that the process was allowed",
    "pinned": "whether these were as many as requested, rather than all there are",
    "machine": "hash of the machine's fingerprint, which the table's metadata hold in full",
}


def raw_rows(
    robot: Robot,
    targets: Array,
    answers: Sequence[Solution],
    times_us: Array,
    config: EvaluateConfig,
    always_answers: bool,
    freedoms: Sequence[Freedom] | None = None,
) -> pd.DataFrame:
    """Judge the answers to a run of poses: errors come from the joints, never from the solver.

    Args:
        robot: The robot.
        targets: (N, 7) requested poses.
        answers: Solutions of consecutive batches, N rows together.
        times_us: (N,) wall time per pose [us].
        config: Tolerance of a claim, slack of a limit.
        always_answers: Every answer counts, found or not.
        freedoms: What each target leaves open; errors are those to the nearest pose it allows.

    Returns:
        N rows with the columns of `COLUMNS` from ``found`` to the joints.
    """
    joints = np.concatenate([answer.joints for answer in answers])
    found = np.concatenate([answer.found for answer in answers]).astype(bool)
    errors = free_errors(targets, tip_poses(robot, joints), freedoms)
    inside = within_limits(robot, joints, config.limit_slack)
    missed = (errors.position_mm >= config.claim.position_mm) | (
        errors.rotation_deg >= config.claim.rotation_deg
    )
    columns: dict[str, Any] = {
        "found": found,
        "answered": found | always_answers,
        "reason": [reason for answer in answers for reason in answer.reason],
        **_error_columns(errors, ""),
        **_error_columns(idle_errors(robot, targets, freedoms), "idle_"),
        "within_limits": inside,
        "self_collision": self_collisions(robot, joints),
        "claimed_and_wrong": found & (missed | ~inside),
        "time_per_pose_us": times_us,
        "solver_time_us": np.concatenate([answer.time_s for answer in answers]) * US_PER_S,
        "iterations": np.concatenate([answer.iterations for answer in answers]),
    }
    columns |= {f"target_{axis}_m": targets[:, index] for index, axis in enumerate("xyz")}
    columns |= {f"q{joint}": joints[:, joint] for joint in range(robot.dof)}
    return pd.DataFrame(columns)


def idle_errors(
    robot: Robot, targets: Array, freedoms: Sequence[Freedom] | None = None
) -> PoseErrors:
    """Errors of the idle configuration: what the paper counts where a solver returns nothing."""
    idle = tip_poses(robot, np.asarray(robot.home, dtype=np.float64)[None])
    return free_errors(targets, np.repeat(idle, len(targets), axis=0), freedoms)


def free_errors(
    targets: Array, reached: Array, freedoms: Sequence[Freedom] | None = None
) -> PoseErrors:
    """Errors of reached poses (N, 7), to targets or to the nearest poses that these allow."""
    if freedoms is None:
        return pose_errors(targets, reached)
    widths = widths_of(freedoms, len(targets))
    return pose_errors(nearest_allowed(targets, reached, widths), reached)


def _error_columns(errors: PoseErrors, kind: str) -> dict[str, Array]:
    return {
        f"{kind}position_error_mm": errors.position_mm,
        f"{kind}rotation_error_deg": errors.rotation_deg,
        f"paper_{kind}position_error_mm": errors.paper_position_mm,
        f"paper_{kind}rotation_error_deg": errors.paper_rotation_deg,
    }
