"""Claim `same_precision_in_batches`: a pose is answered alike whatever the size of the batch.

1,000 poses a robot, one, 100 and 1,000 a call, with the networks that come with the project (and
Table I's where ``--networks`` says where trained ones lie). It holds if no joint differs from its
answer alone by more than 1e-3 rad or m.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

from baselines import Solver
from pipeline import load_solver
from robots import available_robots, load_robot

NAME, SEEDS = "claim_batches", "of poses 3"
POSES, SIZES = 1000, (1, 100, 1000)
LARGEST = 1e-3  # rad or m


def run(networks: Path | None) -> tuple[pd.DataFrame, str]:
    """Answer in batches of each size; rows and the verdict."""
    rows = []
    for name in available_robots():
        robot = load_robot(name)
        folder = networks / name / "paper" if networks else None
        solvers: dict[str, Solver] = {"compact": load_solver("cycleik", robot)}
        if folder is not None and folder.exists():
            solvers["table_one"] = load_solver("cycleik", robot, weights=folder)
        poses = robot.forward_kinematics(robot.sample(POSES, seed=3))
        for network, solver in solvers.items():
            answers = {
                size: np.concatenate(
                    [solver.solve(poses[k : k + size]).joints for k in range(0, POSES, size)]
                )
                for size in SIZES
            }
            rows += [
                {
                    "robot": name,
                    "network": network,
                    "batch": size,
                    "largest_difference_rad_or_m": np.abs(answers[size] - answers[1]).max(),
                }
                for size in SIZES
            ]
    table = pd.DataFrame(rows)
    worst = table.largest_difference_rad_or_m.max()
    return table, (
        f"The largest difference of a joint from its answer alone is {worst:.1e} rad or m: the "
        f"claim {'holds' if worst <= LARGEST else 'does not hold'} (required: {LARGEST:g} at most)."
    )
