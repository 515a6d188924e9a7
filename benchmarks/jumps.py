"""Where a solver jumps while it follows the suite `tracking`, and whether it had to.

    python -m benchmarks.jumps results/quick/evaluate_suite/panda/tracking/lm.parquet

Reads raw rows of `python -m pipeline suites suites=[tracking]` and, of every step of more than 0.1
rad or m, looks again from the answer before: with joints held within that distance of it, many
starts and much patience. What is then found says that there was no need to jump; where nothing is,
earlier answers have drifted to where the solution that the suite knows can no longer be followed.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
import pandas as pd

import baselines
from baselines.lm import LevenbergMarquardt
from baselines.lm_kernel import FOUND, refine_row
from baselines.lm_query import drawn_in
from baselines.seed_library import empty_seed_library
from pipeline.data.dataset import POSE_COLUMNS, joint_columns
from pipeline.data.tables import read_metadata, read_table
from pipeline.reporting.suite_measures import JUMP
from robots import load_robot

STARTS, PATIENCE, ITERATIONS = 64, 30, 10_000


def main() -> None:
    """Print a line for each jump."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("rows", type=Path)
    table = again(parser.parse_args().rows)
    print(table.to_string(index=False) if len(table) else "no step is a jump")
    print(table.groupby(["rate_hz", "avoidable"]).trajectory.nunique().to_string())


def again(path: Path) -> pd.DataFrame:
    """Return the jumps in raw rows of `tracking`, and what a search near the last answer finds."""
    rows, name = read_table(path), str(read_metadata(path)["robot"])
    suite = read_table(path.parents[3] / "suite" / name / f"{path.parent.name}.parquet")
    robot = load_robot(name)
    kernel = baselines.load("lm", robot)
    assert isinstance(kernel, LevenbergMarquardt)
    options = kernel.options(None)._replace(
        starts=STARTS, patience=PATIENCE, iterations=ITERATIONS, nearest_starts=0
    )
    joints = rows[joint_columns(robot)].to_numpy(dtype=np.float64)
    known = suite[joint_columns(robot)].to_numpy(dtype=np.float64)
    poses = suite[list(POSE_COLUMNS)].to_numpy(dtype=np.float64)
    library, found = empty_seed_library(robot.dof), []
    for row in np.flatnonzero(rows.joint_step.to_numpy() > JUMP):
        before, near = joints[row - 1], np.empty(robot.dof)
        chain = drawn_in(robot.chain, before, JUMP)
        status, *_ = refine_row(chain, poses[row], before[None].copy(), library, options, near)
        found.append(
            {
                "rate_hz": rows.rate_hz[row],
                "trajectory": rows.trajectory[row],
                "step": rows.step[row],
                "jump": rows.joint_step[row],
                "at_limit": bool((before <= robot.lower).any() or (before >= robot.upper).any()),
                "from_known": float(np.abs(before - known[row]).max()),
                "avoidable": status == FOUND,
            }
        )
    columns = ["rate_hz", "trajectory", "step", "jump", "at_limit", "from_known", "avoidable"]
    return pd.DataFrame(found, columns=columns)


if __name__ == "__main__":
    main()
