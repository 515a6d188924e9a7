"""Claim `out_of_distribution`: poses outside the training data give unexpected answers.

NICOL's network was trained in a box of its workspace, a quarter of what it can reach: 10,000 poses
inside and as many reachable ones outside, by distance from the box. It holds if success (10 mm and
20 deg in the paper's metric) outside is less than half of that inside.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd

from pipeline import load_solver
from pipeline.evaluation.metrics import pose_errors
from pipeline.evaluation.verification import tip_poses
from robots import load_robot

NAME, SEEDS = "claim_domain", "of poses 4 and 5"
POSES = 10_000
RINGS_M = (0.0, 0.02, 0.05, 0.1, 0.2, np.inf)  # distance from the box


def run() -> tuple[pd.DataFrame, str]:
    """Answer inside and outside; rows and the verdict."""
    robot = load_robot("nicol")
    solver = load_solver("cycleik", robot)
    inside = robot.forward_kinematics(robot.sample(POSES, seed=4, workspace_filter=True))
    anywhere = robot.forward_kinematics(robot.sample(2 * POSES, seed=5))
    low, high = robot.workspace
    gaps = np.maximum(low - anywhere[:, :3], anywhere[:, :3] - high).clip(min=0)
    distance = np.linalg.norm(gaps, axis=1)
    places = [("inside the box", inside)]
    for near, far in pairwise(RINGS_M):
        chosen = anywhere[(distance > near) & (distance <= far)]
        places.append((f"{1e3 * near:.0f} to {1e3 * far:.0f} mm outside", chosen))
    places.append(("outside", anywhere[distance > 0]))
    rows = []
    for place, poses in places:
        errors = pose_errors(poses, tip_poses(robot, solver.solve(poses).joints))
        good = (errors.paper_position_mm < 10) & (errors.paper_rotation_deg < 20)
        rows.append(
            {
                "place": place,
                "poses": len(poses),
                "position_mm": errors.paper_position_mm.mean(),
                "position_mm_median": np.median(errors.paper_position_mm),
                "rotation_deg": errors.paper_rotation_deg.mean(),
                "success_percent": 100 * good.mean(),
            }
        )
    table = pd.DataFrame(rows)
    within, beyond = table.success_percent.iloc[0], table.success_percent.iloc[-1]
    return table, (
        f"Success is {within:.1f} % inside the box and {beyond:.1f} % of reachable poses outside: "
        f"the claim {'holds' if beyond < within / 2 else 'does not hold'} (asked: less than half)."
    )
