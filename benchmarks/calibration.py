"""Is TRAC-IK here the TRAC-IK that its authors measured? Their protocol, our set-up.

    python -m benchmarks.calibration [--poses 10000]

The README of trac_ik 1.4.6 (Beeson and Ames) gives solve rates and mean times for 10,000 poses of
random configurations, each solved from the middle of the limits within 5 ms to 1e-5 in every
component of the twist. Three of its arms are among our robots: the Panda, Fetch's arm without the
lift, Valkyrie's arm without the waist. Prints the published figures beside ours and writes
results/studies/calibration.{csv,md}; it takes a minute or two, and wants a quiet machine, since
the library races two threads against the clock.
"""

from __future__ import annotations

import argparse
from typing import NamedTuple

import numpy as np
import pandas as pd

import baselines
from baselines import Budget
from benchmarks.studies import write_study
from pipeline.evaluation.statistics import wilson_interval
from robots import Robot, load_robot
from robots.description import find_description
from robots.rotations import rotation_angle

TIME_S, EPSILON, SEED = 5e-3, 1e-5, 1
CONFIDENCE = 0.95


class Arm(NamedTuple):
    """An arm that the library's authors measured.

    Attributes:
        robot: Whose description has it.
        base: Link that it begins at; None for the robot's own chain.
        published_percent: Share of solved poses [%].
        published_ms: Mean time over solved and unsolved poses [ms].
    """

    robot: str
    base: str | None
    published_percent: float
    published_ms: float


ARMS = (
    Arm("panda", None, 99.70, 0.38),
    Arm("fetch", "torso_lift_link", 99.99, 0.26),
    Arm("valkyrie", "torso", 99.81, 0.46),
)


def arm(robot: str, base: str | None) -> Robot:
    """Load a robot, or the part of its chain that begins at a link."""
    if base is None:
        return load_robot(robot)
    description = find_description(robot)
    return load_robot(urdf=description.urdf, base=base, tip=description.tip)


def measured(robot: Robot, count: int) -> tuple[int, float, float, float]:
    """Solved poses, mean time [ms], and the largest errors [m, rad] among the solved."""
    joints = robot.sample(count, seed=SEED, collision_free=False)
    poses = robot.forward_kinematics(joints)
    solver = baselines.load("trac_ik", robot, epsilon=EPSILON, time_s=TIME_S)
    middle = (robot.lower + robot.upper) / 2
    solution = solver.solve(poses, middle, Budget(time_s=TIME_S))
    found = solution.found
    reached = robot.forward_kinematics(solution.joints[found])
    distance = np.linalg.norm(reached[:, :3] - poses[found, :3], axis=1).max()
    angle = rotation_angle(reached[:, 3:], poses[found, 3:]).max()
    return int(found.sum()), 1e3 * float(solution.time_s.mean()), float(distance), float(angle)


def main() -> None:
    """Run and write the study."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--poses", type=int, default=10_000)
    poses = parser.parse_args().poses
    rows = []
    for chosen in ARMS:
        robot = arm(chosen.robot, chosen.base)
        solved, time_ms, distance, angle = measured(robot, poses)
        interval = wilson_interval(solved, poses, CONFIDENCE)
        rows.append(
            {
                "arm": f"{chosen.robot} from {chosen.base}" if chosen.base else chosen.robot,
                "joints": robot.dof,
                "poses": poses,
                "published_percent": chosen.published_percent,
                "solved_percent": round(100 * solved / poses, 3),
                "low_percent": round(100 * interval.low, 3),
                "high_percent": round(100 * interval.high, 3),
                "published_ms": chosen.published_ms,
                "mean_ms": round(time_ms, 4),
                "largest_error_um": round(1e6 * distance, 2),
                "largest_error_urad": round(1e6 * angle, 2),
            }
        )
        print(rows[-1], flush=True)
    table = pd.DataFrame(rows)
    text = (
        "TRAC-IK under its authors' protocol: 10,000 poses of random configurations, from the\n"
        "middle of the limits, 5 ms, 1e-5 in every component of the twist; 95 % Wilson intervals.\n"
        f"Published: README of trac_ik 1.4.6.\n\n{table.to_markdown(index=False)}\n"
    )
    command = f"python -m benchmarks.calibration --poses {poses}"
    write_study("calibration", table, text, command, str(SEED))


if __name__ == "__main__":
    main()
