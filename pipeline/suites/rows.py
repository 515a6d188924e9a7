"""Raw rows of a suite: those of an evaluation, and what the suite says of each pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.data.dataset import joint_columns
from pipeline.suites.generators import Suite
from pipeline.suites.problems import EVIDENCE, OBSTACLES, STRATUM, Problems
from pipeline.suites.verdicts import COLUMNS as VERDICTS
from pipeline.suites.verdicts import verdicts
from robots import Obstacles

if TYPE_CHECKING:
    from robots import Robot

Array = NDArray[np.float64]

COLUMNS = {  # beside those of pipeline.evaluation.rows
    "suite": "name of the suite",
    "suite_generator": "what is in it",
    "suite_version": "its version",
    STRATUM: "kind of problem within it",
    "known_distance": "largest joint distance from the known configuration [rad or m]; else NaN",
    "trajectory": "number of the trajectory; only in tracking, as the columns that follow",
    "step": "number of the waypoint on it",
    "rate_hz": "waypoints a second",
    "joint_step": "largest joint distance from the answer to the waypoint before [rad or m]",
}
AMONG_OBSTACLES = {  # beside those, in cluttered alone
    "clearance_mm": "that the known configuration keeps [mm]",
    "asked": "whether the solver was told the obstacles and the clearance",
    **VERDICTS,
}


def initial(problems: Problems, robot: Robot) -> Array | None:
    """Return where solvers start, (N, dof); home where a pose follows another."""
    if problems.start is None:
        return None
    return np.where(np.isnan(problems.start), robot.home, problems.start)


def follows(problems: Problems) -> NDArray[np.bool_] | None:
    """Return which poses (N,) start from the answer to the one before; None where none does."""
    step = problems.further.get("step")
    return None if step is None else np.asarray(step > 0)


def obstacles(problems: Problems) -> list[Obstacles] | None:
    """Return the obstacles of each pose with the clearance that is asked; None where none stand."""
    said = problems.further.get(OBSTACLES)
    return None if said is None else [Obstacles.from_json(str(each)) for each in said]


def with_problems(
    rows: pd.DataFrame, suite: Suite, robot: Robot, asked: bool = False
) -> pd.DataFrame:
    """Add the columns of `COLUMNS`, and those of `AMONG_OBSTACLES` where obstacles stand, to rows.

    Args:
        rows: Answers to a suite, of `pipeline.evaluation.rows`; ``pose`` is the row of the suite.
        suite: That was answered.
        robot: The robot.
        asked: Whether the solver was told what to avoid, where there is anything.
    """
    problems = suite.problems.at(rows.pose.to_numpy())
    joints = rows[joint_columns(robot)].to_numpy(dtype=np.float64)
    rows = rows.assign(
        suite=suite.name,
        suite_generator=suite.generator,
        suite_version=suite.version,
        stratum=problems.stratum,
    )
    known = problems.joints
    turned = robot.nearest_turns(joints, np.where(np.isnan(known), joints, known))
    rows["known_distance"] = np.abs(turned - known).max(axis=1)
    for name, values in problems.further.items():
        if not name.startswith(EVIDENCE) and name != OBSTACLES:
            rows[name] = values
    if (sets := obstacles(problems)) is not None:
        rows = rows.assign(asked=asked, **verdicts(robot, joints, sets))
    if "step" in problems.further:
        step = np.full(len(rows), np.nan)
        after = robot.nearest_turns(joints[1:], joints[:-1])
        step[1:] = np.abs(after - joints[:-1]).max(axis=1)
        rows["joint_step"] = np.where(problems.further["step"] > 0, step, np.nan)
    return rows
