"""Claim `sign_ambiguity`: the former rotation loss explodes where a batch has both signs of q.

The same network, poses and steps, without clipping: former losses (equations 3 and 6) and new ones
(5 and 8), on the data's quaternions with w >= 0 and with a sign drawn for each pose at each step.
It holds if the mean norm of the former loss's gradient is at least ten times as large with both
signs; that the loss is no use with them is another question, which the errors answer.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pandas as pd
import torch
from torch import Tensor

from benchmarks.claims.fitting import fit, pose_sets
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.presentation.naming import robot_title
from robots import load_robot

NAME, SEEDS = "claim_signs", "of weights and order 0; of poses 0 and 1; of signs the step"
FACTOR = 10.0
ROBOTS = ("nico", "panda")


class BothSigns(CycleObjective):
    """The cycle with a target quaternion of either sign."""

    def loss(self, poses: Tensor, joints: Tensor, step: int, done: float) -> Tensor:
        """See `Objective.loss`."""
        drawn = torch.Generator().manual_seed(step)
        targets = poses.clone()
        targets[:, 3:] *= 2 * torch.randint(2, (len(poses), 1), generator=drawn) - 1
        return self.loss_of(poses, targets)


SIGNS = {"w >= 0": CycleObjective, "both": BothSigns}


def run() -> tuple[pd.DataFrame, str]:
    """Train with each loss and kind of sign; rows and the verdict."""
    rows = []
    for name in ROBOTS:
        robot = load_robot(name)
        data = pose_sets(robot)
        for loss, signs in product(("former", "smooth"), SIGNS):
            recipe = ("train.epochs=10", "train.gradient_clip=null", f"train.loss={loss}")
            ended = fit(robot, data, 0, *recipe, objective=SIGNS[signs])
            norms = ended.gradient_norms
            rows.append(
                {
                    "robot": name,
                    "loss": loss,
                    "signs": signs,
                    "position_mm": ended.position_mm,
                    "rotation_deg": ended.rotation_deg,
                    "gradient_mean": norms.mean(),
                    "gradient_median": np.median(norms),
                    "gradient_largest": norms.max(),
                }
            )
    table = pd.DataFrame(rows)
    former = table[table.loss == "former"].pivot(index="robot", columns="signs")
    ratio = former["gradient_mean"]["both"] / former["gradient_mean"]["w >= 0"]
    error = former["rotation_deg"]
    errors = ", ".join(
        f"{error['w >= 0'][name]:.1f} to {error['both'][name]:.1f} deg on {robot_title(name)}"
        for name in ROBOTS
    )
    verdict = "holds" if (ratio >= FACTOR).all() else "does not hold"
    return table, (
        f"With both signs the former loss's gradient is {ratio.min():.2f} to {ratio.max():.2f} "
        f"times as large on average: the claim that it explodes {verdict} (required: {FACTOR:g}); "
        f"its rotation error goes from {errors}."
    )
