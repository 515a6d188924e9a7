"""What the motion in the null space does where trajectories are followed, with it and without.

    python -m benchmarks.following [--robots panda ...] [--solvers lm ...] [--write]

The trajectories are those of the suite `tracking`; a step is one call of `follow_one` (with), or of
`solve_one` from the answer before (without). A solver that takes `max_jump` follows a second time
with each step held to 0.09 rad or m: an answer further away is none. `follow_path` knows the whole
trajectory beforehand and may begin again from its start. Robots of `benchmarks.package_robots` are
added where they are not there yet. Prints a Markdown table: trajectories with a step of more than
0.1 rad or m, and with a miss; the largest step of those with neither, and of the motion that made
them; mean errors of what is answered; the mean distance from that motion; the 10th percentile of
the time of a step, of a path its time by poses.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines import SkippedSolver
from baselines.following import FollowingSolver
from baselines.registry import settings
from benchmarks.package_robots import ensure
from benchmarks.query import markdown
from benchmarks.studies import write_study
from pipeline import load_robot, load_solver
from pipeline.config import compose
from pipeline.learning.card import WeightsError
from pipeline.reporting.suite_measures import JUMP
from pipeline.suites.generators import generate
from pipeline.suites.problems import Problems
from robots import Robot
from robots.rotations import rotation_angle

Array = NDArray[np.float64]
Step = Callable[[Array, Array], tuple[Array, bool]]

NAMES = ("panda", "fetch", "nicol", "nico", "iiwa")
SOLVERS = ("lm", "cycleik_refined")
TITLE = (
    "Trajectories of the suite `tracking`, every pose from the answer before: with the motion in\n"
    "the null space (`follow`) and without, with steps held to `max_jump` and without; or as a\n"
    "path that is known beforehand (`follow_path`, up to 128 attempts from its start). Jump: a\n"
    f"trajectory has a step of more than {JUMP:g} rad (m); miss: it has a pose without an answer;\n"
    "lost: either. Steps in rad (m): the largest of those that are not lost, and of the motion\n"
    "that made them; drift is the mean distance from it, the joint that is furthest off."
)
HELD = 0.09  # rad or m, `max_jump` of the rows that have one


@dataclass(frozen=True)
class Followed:
    """Answers to all poses, whether each was found, and the time of its call [us]."""

    joints: Array
    found: NDArray[np.bool_]
    time_us: Array


def follow(step: Step, problems: Problems) -> Followed:
    """Answer poses one after the other, the first of a trajectory from its known configuration."""
    poses, known, number = problems.poses, problems.joints, problems.further["step"]
    joints, found, spent = np.empty_like(known), np.zeros(len(poses), dtype=bool), []
    for row, pose in enumerate(poses):
        last = known[row] if number[row] == 0 else joints[row - 1]
        began = time.perf_counter_ns()
        joints[row], found[row] = step(pose, last)
        spent.append((time.perf_counter_ns() - began) / 1e3)
    return Followed(joints, found, np.array(spent))


def follow_paths(solver: FollowingSolver, problems: Problems) -> Followed:
    """Follow each trajectory as a path that is known, from its known configuration."""
    further = problems.further
    joints, time_us = np.empty_like(problems.joints), np.empty(len(problems.poses))
    for number, rate in {*zip(further["trajectory"], further["rate_hz"], strict=True)}:
        rows = np.logical_and(further["trajectory"] == number, further["rate_hz"] == rate)
        began = time.perf_counter_ns()
        start = problems.joints[rows][0]
        joints[rows] = solver.follow_path(problems.poses[rows], start, max_jump=HELD).joints
        time_us[rows] = (time.perf_counter_ns() - began) / 1e3 / rows.sum()
    return Followed(joints, ~np.isnan(joints[:, 0]), time_us)


def measures(robot: Robot, problems: Problems, answers: Followed) -> Iterator[dict[str, Any]]:
    """Give the figures of each rate."""
    answered = ~np.isnan(answers.joints[:, 0])
    reached = robot.forward_kinematics(np.where(answered[:, None], answers.joints, robot.home))
    distance = 1e3 * np.linalg.norm(reached[:, :3] - problems.poses[:, :3], axis=1)
    angle = np.degrees(rotation_angle(reached[:, 3:], problems.poses[:, 3:]))
    first = problems.further["step"] == 0
    own, known = (_steps(joints, first) for joints in (answers.joints, problems.joints))
    number, off = problems.further["trajectory"], np.abs(answers.joints - problems.joints)
    for rate in np.unique(problems.further["rate_hz"]):
        rows = problems.further["rate_hz"] == rate
        measured = rows & answered
        jumping = np.unique(number[rows & (own > JUMP)])
        missing = np.unique(number[rows & ~answers.found])
        lost = np.union1d(jumping, missing)
        kept = rows & ~np.isin(number, lost)
        yield {
            "hz": int(rate),
            "trajectories": len(np.unique(number[rows])),
            "jump": len(jumping),
            "miss": len(missing),
            "lost": len(lost),
            "largest step": own[kept].max(),
            "of the motion": known[rows].max(),
            "error um": 1e3 * distance[measured].mean(),
            "error mdeg": 1e3 * angle[measured].mean(),
            "drift": off[measured].max(axis=1).mean(),
            "step us": np.percentile(answers.time_us[rows], 10),
            "mean us": answers.time_us[rows].mean(),
        }


def _steps(joints: Array, first: NDArray[np.bool_]) -> Array:
    """Largest change of a joint since the configuration before, 0 where there is none."""
    changes = np.abs(np.diff(joints, axis=0, prepend=joints[:1])).max(axis=1)
    return np.where(first, 0.0, changes)


def rows_of(names: list[str], solvers: list[str], trajectories: int) -> Iterator[dict[str, Any]]:
    """Give a row for each robot, solver, way of following and rate, as soon as it is there."""
    config = compose(["suite=tracking", f"suite.trajectories={trajectories}"])
    for name in names:
        ensure(name)
        robot = load_robot(name)
        problems = generate(robot, config.suite, config.seed).problems
        for label in solvers:
            for held in (None, HELD) if "max_jump" in settings(label) else (None,):
                bound: dict[str, Any] = {} if held is None else {"max_jump": held}
                try:
                    solver = load_solver(label, robot, **bound)
                except (SkippedSolver, WeightsError):  # no network knows an added robot
                    continue
                assert isinstance(solver, FollowingSolver)
                ways: dict[str, Step] = {"no": solver.solve_one, "yes": solver.follow_one}
                what: dict[str, Any] = {"robot": name, "solver": label}
                if held is not None or "max_jump" not in settings(label):
                    solver.follow_path(problems.poses[:1], problems.joints[0])  # compiles
                    for figures in measures(robot, problems, follow_paths(solver, problems)):
                        yield what | {"null space": "path", "max jump": HELD} | figures
                for way, step in ways.items():
                    step(problems.poses[0], problems.joints[0])  # compiles
                    for figures in measures(robot, problems, follow(step, problems)):
                        yield what | {"null space": way, "max jump": held or "none"} | figures


def main() -> None:
    """Print the table, and write it where that is requested."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=list(NAMES))
    parser.add_argument("--solvers", nargs="+", default=list(SOLVERS))
    parser.add_argument("--trajectories", type=int, default=200)
    parser.add_argument("--write", action="store_true", help="also into results/studies")
    options = parser.parse_args()
    kept = []
    for row in rows_of(options.robots, options.solvers, options.trajectories):
        print(row, flush=True)
        kept.append(row)
    table = pd.DataFrame(kept)
    text = f"{TITLE}\n\n{markdown(table.round(4))}"
    print(text)
    if options.write:
        chosen = f"--robots {' '.join(options.robots)} --solvers {' '.join(options.solvers)}"
        command = f"python -m benchmarks.following {chosen} --write"
        write_study("following", table, text, command, "0")


if __name__ == "__main__":
    main()
