"""Raw rows of a suite: those of an evaluation, and what the suite says of each pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines.abilities import EXPLAIN
from baselines.abilities import PARTIAL as ABILITY
from baselines.explanation import LIMITS, ORIENTATION, OUT_OF_REACH
from pipeline.data.dataset import joint_columns
from pipeline.suites.config import PARTIAL, UNREACHABLE
from pipeline.suites.generators import Suite
from pipeline.suites.problems import EVIDENCE, OBSTACLES, STRATUM, Problems
from pipeline.suites.unreachable import ORIENTATION as ORIENTATION_KIND
from pipeline.suites.verdicts import COLUMNS as VERDICTS
from pipeline.suites.verdicts import verdicts
from robots import Obstacles

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]

FREEDOMS, WHOLE_POSE = "freedoms", "whole pose"
# Poses beyond reach are out of it. At the edge of reach a place has a configuration and the
# orientation none inside the limits; whether one outside them has it, nobody knows beforehand.
TRUE_REASONS = {ORIENTATION_KIND: (ORIENTATION, LIMITS)}

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
ABILITY_COLUMNS = {  # of suites that ask for more than a pose
    "along_x_m": "freedom of the target along x of its frame, by which it is judged [m]; likewise "
    "along y and z, and about_x_rad [rad] about the axes; only in partial, as solved_as",
    "solved_as": "what was requested of the solver: the freedoms, or the whole pose",
    "explained": "why there is no solution, by solvers that say it; only in unreachable",
    "explained_right": "whether that is true of the kind of problem; only in unreachable",
}
AMONG_OBSTACLES = {  # beside those, in cluttered alone
    "clearance_mm": "that the known configuration keeps [mm]",
    "obstacles_given": "whether the solver was given the obstacles and the clearance",
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
    """Return the obstacles of each pose and the requested clearance; None where none stand."""
    said = problems.further.get(OBSTACLES)
    return None if said is None else [Obstacles.from_json(str(each)) for each in said]


def with_abilities(rows: pd.DataFrame, suite: Suite, solver: Solver) -> pd.DataFrame:
    """Add what was requested of a solver, or how it explains its "no", where a suite is about that.

    Args:
        rows: Of `with_problems`.
        suite: That was answered.
        solver: That answered it.
    """
    if suite.generator == PARTIAL:
        return rows.assign(solved_as=WHOLE_POSE if solver.lacks(ABILITY) else FREEDOMS)
    if suite.generator != UNREACHABLE or solver.lacks(EXPLAIN):
        return rows
    poses = suite.problems.poses[rows.pose.to_numpy()]
    reasons = [solver.explain(pose).reason for pose in poses]
    right = [
        reason in TRUE_REASONS.get(kind, (OUT_OF_REACH,))
        for kind, reason in zip(rows.stratum, reasons, strict=True)
    ]
    return rows.assign(explained=reasons, explained_right=right)


def with_problems(
    rows: pd.DataFrame, suite: Suite, robot: Robot, obstacles_given: bool = False
) -> pd.DataFrame:
    """Add the columns of `COLUMNS`, and those of `AMONG_OBSTACLES` where obstacles stand, to rows.

    Args:
        rows: Answers to a suite, of `pipeline.evaluation.rows`; ``pose`` is the row of the suite.
        suite: That was answered.
        robot: The robot.
        obstacles_given: Whether the solver was given what to avoid, where there is anything.
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
        rows = rows.assign(obstacles_given=obstacles_given, **verdicts(robot, joints, sets))
    if "step" in problems.further:
        step = np.full(len(rows), np.nan)
        after = robot.nearest_turns(joints[1:], joints[:-1])
        step[1:] = np.abs(after - joints[:-1]).max(axis=1)
        rows["joint_step"] = np.where(problems.further["step"] > 0, step, np.nan)
    return rows
