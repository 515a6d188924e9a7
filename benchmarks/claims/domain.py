"""Claim `out_of_distribution`: poses outside the training data give unexpected answers.

NICOL's network was trained in a box of its workspace, a quarter of what it can reach: 10,000 poses
inside, and those of 20,000 reachable ones that lie outside, by distance from it. It holds if
success (10 mm and 20 deg in the paper's metric) outside is less than half of that inside.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd

from pipeline import load_solver
from pipeline.config import compose
from pipeline.evaluation.metrics import pose_errors, within
from pipeline.evaluation.verification import tip_poses
from robots import load_robot

NAME, SEEDS = "claim_domain", "of poses 4 and 5"
POSES = 10_000
RINGS_M = (0.0, 0.02, 0.05, 0.1, 0.2, np.inf)  # distance from the box


def run() -> tuple[pd.DataFrame, str]:
    """Answer inside and outside; rows and the verdict."""
    robot, limits = load_robot("nicol"), compose().report.success.paper
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
        good = within(
            errors.paper_position_mm,
            errors.paper_rotation_deg,
            limits.position_mm,
            limits.rotation_deg,
        )
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
    inner, outer = table.success_percent.iloc[0], table.success_percent.iloc[-1]
    verdict = "holds" if outer < inner / 2 else "does not hold"
    return table, (
        f"Success is {inner:.1f} % inside the box and {outer:.1f} % of reachable poses outside: "
        f"the claim {verdict} (required: less than half)."
    )
