"""Many solutions of one pose: raw rows of a solver that draws, before and after refinement."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, cast, runtime_checkable

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

import baselines
from baselines.lm import LevenbergMarquardt
from baselines.refine import Refined, refine
from pipeline.errors import PipelineError
from pipeline.evaluation.config import SampleConfig
from pipeline.evaluation.metrics import pose_errors
from pipeline.evaluation.verification import tip_poses, within_limits
from pipeline.seeding import derive_seed

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]

COLUMNS = {
    "robot": "name of the robot",
    "solver": "name of the solver that drew",
    "pose": "row of the pose in the test set",
    "sample": "number of the solution of that pose",
    "reference": "by lm from a random start, whatever the solver (true), or drawn (false)",
    "refined": "before refinement (false) or after it",
    "found": "after refinement: the tolerances of lm are met; before it never claimed",
    "starts": "descents of the refinement; more than 1: it left the solution for a random start",
    "position_error_mm": "Euclidean distance of the joints' tip from the target [mm]",
    "rotation_error_deg": "geodesic angle between them [deg]",
    "within_limits": "every joint within its limits, rounding aside",
    "in_collision": "links of the robot touch that may not",
    "q0": "joints, base to tip: q0, q1, … [rad or m]",
}


class SolutionSamplingError(PipelineError):
    """A solver that cannot draw."""


@runtime_checkable
class Sampler(Protocol):
    """A solver that draws many solutions of one pose."""

    def sample(self, poses: ArrayLike, count: int, seed: int) -> Array:
        """Return joints (N, count, dof) for poses (N, 7), the same for the same seed."""


def sampler_of(solver: Solver) -> Sampler:
    """Return the solver as one that draws.

    Raises:
        SolutionSamplingError: It does not.
    """
    if not isinstance(solver, Sampler):
        raise SolutionSamplingError(
            f"sample.solver: '{solver.name}' gives one answer to a pose; expected a solver that "
            f"draws, such as null_space"
        )
    return cast(Sampler, solver)


def sample_rows(
    robot: Robot, solver: Solver, poses: Array, config: SampleConfig, limit_slack: float
) -> pd.DataFrame:
    """Draw solutions of each pose, refine every one, and judge both by Pinocchio.

    Args:
        robot: The robot.
        solver: Solver that draws for it.
        poses: (N, 7) targets.
        config: Solutions of each pose and their seed.
        limit_slack: rad or m that a joint may lie beyond its limit.

    Returns:
        Two rows a solution, and one for each reference, with the columns of `COLUMNS`.
    """
    drawn = sampler_of(solver).sample(poses, config.samples, config.seed)
    raw: dict[str, Any] = {"reference": False, "refined": False, "found": False, "starts": 0}
    refined = _refined(robot, poses, drawn)
    done = {"reference": False, "refined": True, "found": refined.found, "starts": refined.starts}
    parts: list[tuple[Array, dict[str, Any]]] = [
        (np.asarray(drawn, dtype=np.float64).reshape(-1, robot.dof), raw),
        (refined.joints, done),
    ]
    if config.references:
        shape = (len(poses), config.references, robot.dof)
        count = shape[0] * shape[1]
        seed = derive_seed(config.seed, "references")
        starts = robot.sample(count, seed=seed, collision_free=False)
        solved = _refined(robot, poses, starts.reshape(shape))
        facts = {"reference": True, "refined": True, "found": solved.found, "starts": solved.starts}
        parts.append((solved.joints, facts))
    rows = [_rows(robot, solver, poses, *part, limit_slack) for part in parts]
    return pd.concat(rows, ignore_index=True)


def _refined(robot: Robot, poses: Array, starts: Array) -> Refined:
    """Refine configurations (N, K, dof) for poses (N, 7), each by itself, with those of `lm`."""
    kernel = baselines.load("lm", robot)
    assert isinstance(kernel, LevenbergMarquardt)
    seeds = np.ascontiguousarray(starts.reshape(-1, 1, robot.dof), dtype=np.float64)
    targets = np.repeat(poses, starts.shape[1], axis=0)
    return refine(robot, targets, seeds, kernel.options(None))


def _rows(
    robot: Robot,
    solver: Solver,
    poses: Array,
    joints: Array,
    facts: dict[str, Any],
    limit_slack: float,
) -> pd.DataFrame:
    """Judge configurations (N K, dof), K a pose, whose other facts are given."""
    count = len(joints) // len(poses)
    errors = pose_errors(np.repeat(poses, count, axis=0), tip_poses(robot, joints))
    columns: dict[str, Any] = {
        "robot": robot.name,
        "solver": solver.name,
        "pose": np.repeat(np.arange(len(poses)), count),
        "sample": np.tile(np.arange(count), len(poses)),
        **facts,
        "position_error_mm": errors.position_mm,
        "rotation_error_deg": errors.rotation_deg,
        "within_limits": within_limits(robot, joints, limit_slack),
        "in_collision": robot.in_collision(joints),
    }
    columns |= {f"q{joint}": joints[:, joint] for joint in range(robot.dof)}
    return pd.DataFrame(columns)


def joint_columns(rows: pd.DataFrame) -> list[str]:
    """Return the names of the columns that hold joints, base to tip."""
    return [name for name in rows.columns if name[:1] == "q" and name[1:].isdigit()]


def spread(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the standard deviation of each joint over the solutions of a pose.

    Args:
        rows: Rows of one robot and solver, all before or all after refinement.

    Returns:
        A row for each pose, a column for each joint, rad or m.
    """
    return rows.groupby("pose")[joint_columns(rows)].std()


def drawn_rows(rows: pd.DataFrame, refined: bool) -> pd.DataFrame:
    """Return the rows of what was drawn, before or after refinement: no references.

    Files of earlier versions have none.
    """
    drawn = rows.refined == refined
    return rows[drawn & ~rows.reference] if "reference" in rows else rows[drawn]
