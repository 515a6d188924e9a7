"""The planner benchmark: several solvers plan the same motions between random reachable poses."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import baselines
from pipeline.data.rows import RowCheckpoint
from pipeline.planning.config import MotionConfig, PlanConfig
from pipeline.planning.continuity import branch_flips, joint_steps, kernel_options
from pipeline.planning.motion import Motion, plan_motion
from pipeline.planning.path import control_points, tip_path
from pipeline.planning.reach import judge_path
from robots.rotations import rotation_angle

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

Array = NDArray[np.float64]
MS_PER_S = 1e3
KEY = ("solver", "pair")  # identifies a row
VERDICT = ("in_reach", "continuous")  # columns of a row that depend on its pair alone
SHOWN = 100  # pairs that are looked at for one to draw
LIMIT_SLACK = 1e-6  # rad or m; rounding


@dataclass(frozen=True)
class Pair:
    """Start and target of one motion, each the pose of a collision-free configuration.

    Attributes:
        start: Joint values of the start, (dof,).
        target: Pose of the target, (7,).
    """

    start: Array
    target: Array


def random_pairs(robot: Robot, count: int, seed: int) -> list[Pair]:
    """Draw start configurations and target poses; the same seed gives the same pairs."""
    joints = robot.sample(2 * count, seed=seed)
    targets = robot.forward_kinematics(joints[count:])
    return [Pair(start, target) for start, target in zip(joints[:count], targets, strict=True)]


def plan_pair(
    robot: Robot, solver: Solver, pair: Pair, config: PlanConfig, repair: Solver | None
) -> Motion:
    """Plan one motion with the control points that ``config.motion`` places."""
    return plan_by_rule(robot, solver, pair, config.motion, repair)


def plan_by_rule(
    robot: Robot, solver: Solver, pair: Pair, rule: MotionConfig, repair: Solver | None
) -> Motion:
    """Plan one motion with the control points that a rule places; the branch is free."""
    start_pose = robot.forward_kinematics(pair.start)[0]
    inner = control_points(start_pose, pair.target, rule)
    return plan_motion(
        robot,
        solver,
        start_pose,
        pair.target,
        inner,
        steps=rule.steps,
        repair=repair,
        reroute=rule.reroute,
    )


def plan_both(
    robot: Robot, solver: Solver, pair: Pair, config: PlanConfig, repair: Solver | None
) -> tuple[Motion, Motion]:
    """Plan one motion on the requested path at all costs, and as `config.motion` allows."""
    rules = (replace(config.motion, reroute=False), config.motion)
    requested, driven = (plan_by_rule(robot, solver, pair, rule, repair) for rule in rules)
    return requested, driven


def shown_pair(robot: Robot, pairs: list[Pair], rule: MotionConfig) -> Pair:
    """Choose the first pair whose path can be followed with a rule's control points, for figures.

    Args:
        robot: The robot.
        pairs: Pairs, at least one; the first of them where no path can be followed.
        rule: Places the control points.
    """
    options = kernel_options(baselines.load("lm", robot))
    assert options is not None
    for pair in pairs[:SHOWN]:
        start = robot.forward_kinematics(pair.start)[0]
        inner = control_points(start, pair.target, rule)
        if judge_path(robot, tip_path(start, pair.target, inner, rule.steps), options).continuous:
            return pair
    return pairs[0]


def shown_route(rows: pd.DataFrame) -> tuple[str, int] | None:
    """Choose a plan on another curve for a figure: solver and pair with the median detour.

    Plans of paths in reach come first; None if there is no plan on another curve at all.
    """
    other = rows[rows.rerouted & (rows.flips == 0)]
    other = other[other.in_reach] if other.in_reach.any() else other
    if len(other) == 0:
        return None
    middle = other.sort_values("detour_mm", kind="stable").iloc[len(other) // 2]
    return str(middle.solver), int(middle.pair)


def prepared(solver: Solver, config: PlanConfig) -> Solver:
    """Hold a solver to the threads of plans, and one that stops by the clock to their time.

    Both in place. One that stops by iterations is given no time limit: its plans are the same on
    every machine.
    """
    budget = solver.budget
    if budget is not None and budget.time_s is not None:
        solver.budget = replace(budget, time_s=min(budget.time_s, config.time_s))
    if hasattr(solver, "threads"):
        solver.threads = config.threads
    return solver


def benchmark(
    robot: Robot,
    solvers: Mapping[str, Solver],
    config: PlanConfig,
    seed: int,
    kept: RowCheckpoint,
    repair: Solver | None = None,
    progress: Callable[[int], object] | None = None,
) -> pd.DataFrame:
    """Plan every pair with every solver.

    Args:
        robot: The robot.
        solvers: Solvers by name.
        config: Number of pairs, motion, repair.
        seed: Seed of the pairs.
        kept: Finished rows by `KEY`; a killed benchmark goes on after the last of them.
        repair: Solver whose kernel repairs jumps; None leaves each solver to its own.
        progress: Called with 1 after each plan.

    Returns:
        One raw row a pair and solver: plan time, tip error along the path, largest joint step,
        branch flips, waypoints found, limit and collision violations, and if another curve was
        driven how far that leads away; of the batched query alone the same under `query_`; and what
        the requested path allows any planner, see `reach.judge_path`. `busy_ms` is the
        processor time of the calling thread, which other work on the machine changes little; a
        solver with threads of its own has more.
    """
    pairs = random_pairs(robot, config.pairs, seed)
    options = kernel_options(baselines.load("lm", robot))
    assert options is not None
    verdicts: dict[int, dict[str, bool]] = {}
    rows = []
    for name, solver in solvers.items():
        warm = False
        for number, pair in enumerate(pairs):
            row = kept.get(name, number)
            if row is None:
                if not warm:  # compilers and caches warm up before the first time is taken
                    plan_pair(robot, solver, pair, config, repair)
                    warm = True
                begin = time.thread_time()
                motion = plan_pair(robot, solver, pair, config, repair)
                busy_ms = (time.thread_time() - begin) * MS_PER_S
                if number not in verdicts:
                    verdicts[number] = asdict(judge_path(robot, motion.requested, options))
                row = {"robot": robot.name, "solver": name, "pair": number, "busy_ms": busy_ms}
                row |= {**verdicts[number], **judge(robot, motion)}
                kept.put(row)
            verdicts.setdefault(number, {key: row[key] for key in VERDICT})
            rows.append(row)
            if progress is not None:
                progress(1)
    return pd.DataFrame(rows)


def judge(robot: Robot, motion: Motion) -> dict[str, float | int | bool]:
    """Return the figures of one motion, lengths in mm, angles in deg, steps in rad or m."""
    outside = ~robot.within_limits(motion.joints, LIMIT_SLACK)
    answered = robot.forward_kinematics(motion.answers)[:, :3]
    query_error_mm = 1e3 * np.linalg.norm(answered - motion.requested[:, :3], axis=1)
    away_mm = 1e3 * np.linalg.norm(motion.poses[:, :3] - motion.requested[:, :3], axis=1)
    turned = rotation_angle(motion.poses[:, 3:], motion.requested[:, 3:])
    return {
        "plan_time_ms": motion.time_s * MS_PER_S,
        "waypoints": len(motion.poses),
        "waypoints_found": int(motion.found.sum()),
        "tip_error_mm": float(motion.tip_error_mm.max()),
        "tip_error_mean_mm": float(motion.tip_error_mm.mean()),
        "tip_error_deg": float(motion.tip_error_deg.max()),
        "largest_step_rad": motion.largest_step,
        "flips": motion.flips,
        "limit_violations": int(outside.sum()),
        "collisions": int(robot.in_collision(motion.joints).sum()),
        "rerouted": motion.route is not None,
        "detour_mm": float(away_mm.max()),
        "detour_deg": float(np.rad2deg(turned.max())),
        "length_m": _length(motion.poses),
        "requested_length_m": _length(motion.requested),
        "query_time_ms": motion.query_s * MS_PER_S,
        "query_waypoints_found": int(motion.answered.sum()),
        "query_tip_error_mm": float(query_error_mm.max()),
        "query_tip_error_mean_mm": float(query_error_mm.mean()),
        "query_largest_step_rad": float(joint_steps(motion.answers).max()),
        "query_flips": int(branch_flips(robot, motion.answers, motion.requested).sum()),
    }


def _length(poses: Array) -> float:
    """Length of the tip's path [m]."""
    return float(np.linalg.norm(np.diff(poses[:, :3], axis=0), axis=1).sum())
