"""Many solutions of one pose: raw rows of a solver that draws, before and after refinement."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, cast, runtime_checkable

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

import baselines
from baselines.lm import LevenbergMarquardt
from baselines.refine import refine
from pipeline.errors import PipelineError
from pipeline.evaluation.config import SampleConfig
from pipeline.evaluation.metrics import pose_errors
from pipeline.evaluation.verification import tip_poses, within_limits

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]

COLUMNS = {
    "robot": "name of the robot",
    "solver": "name of the solver that drew",
    "pose": "row of the pose in the test set",
    "sample": "number of the solution of that pose",
    "refined": "before refinement (false) or after it",
    "found": "after refinement: the tolerances of lm are met; before it never claimed",
    "starts": "descents of the refinement; more than 1: it left the solution for a random start",
    "position_error_mm": "Euclidean distance of the joints' tip from the target [mm]",
    "rotation_error_deg": "geodesic angle between them [deg]",
    "within_limits": "every joint within its limits, rounding aside",
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
        Two rows a solution, with the columns of `COLUMNS`.
    """
    drawn = sampler_of(solver).sample(poses, config.samples, config.seed)
    joints = np.ascontiguousarray(drawn.reshape(-1, robot.dof), dtype=np.float64)
    targets = np.repeat(poses, config.samples, axis=0)
    kernel = baselines.load("lm", robot)
    assert isinstance(kernel, LevenbergMarquardt)
    refined = refine(robot, targets, joints[:, None], kernel.options(None))
    raw = {"refined": False, "found": False, "starts": 0}
    done = {"refined": True, "found": refined.found, "starts": refined.starts}
    parts = []
    for values, facts in ((joints, raw), (refined.joints, done)):
        errors = pose_errors(targets, tip_poses(robot, values))
        columns: dict[str, Any] = {
            "robot": robot.name,
            "solver": solver.name,
            "pose": np.repeat(np.arange(len(poses)), config.samples),
            "sample": np.tile(np.arange(config.samples), len(poses)),
            **facts,
            "position_error_mm": errors.position_mm,
            "rotation_error_deg": errors.rotation_deg,
            "within_limits": within_limits(robot, values, limit_slack),
        }
        columns |= {f"q{joint}": values[:, joint] for joint in range(robot.dof)}
        parts.append(pd.DataFrame(columns))
    return pd.concat(parts, ignore_index=True)


def spread(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the standard deviation of each joint over the solutions of a pose.

    Args:
        rows: Rows of one robot and solver, all before or all after refinement.

    Returns:
        A row for each pose, a column for each joint, rad or m.
    """
    joints = [name for name in rows.columns if name[:1] == "q" and name[1:].isdigit()]
    return rows.groupby("pose")[joints].std()
