"""Claim `sign_ambiguity`: the former rotation loss explodes where a batch has both signs of q.

The same network, poses and steps: former losses (equations 3 and 6) and new ones (5 and 8), on the
data's quaternions with w >= 0 and with a sign drawn for each pose at each step. It holds if the
mean norm of the former loss's gradient is at least ten times as large with both signs; that the
loss is no use with them is another question, which the errors answer.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
import torch
from torch import Tensor

from benchmarks.claims.fitting import CPU, Batch, fit, pose_sets, recipe, small_network
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.learning.networks import IkNetwork
from pipeline.presentation.naming import robot_title
from robots import load_robot

NAME, SEEDS = "claim_signs", "of weights and order 0; of poses 0 and 1; of signs 7"
FACTOR = 10.0
ROBOTS = ("nico", "panda")


def run() -> tuple[pd.DataFrame, str]:
    """Train with each loss and kind of sign; rows and the verdict."""
    rows = []
    for name in ROBOTS:
        robot = load_robot(name)
        data = pose_sets(robot)
        for loss in ("former", "smooth"):
            train = recipe(robot, "train.epochs=10", f"train.loss={loss}")
            cycle = CycleObjective(robot, small_network(robot, 0), train, CPU)
            for signs in ("w >= 0", "both"):
                drawn = torch.Generator().manual_seed(7)

                def cycle_loss(
                    network: IkNetwork,
                    batch: Batch,
                    cycle: CycleObjective = cycle,
                    drawn: torch.Generator | None = drawn if signs == "both" else None,
                ) -> Tensor:
                    cycle.network = network
                    goals = batch.poses.clone()
                    if drawn is not None:
                        goals[:, 3:] *= 2 * torch.randint(2, (len(goals), 1), generator=drawn) - 1
                    return cycle.loss_of(batch.poses, goals)

                ended = fit(robot, train, cycle_loss, data, seed=0)
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
    holds = bool((ratio >= FACTOR).all())
    error = former["rotation_deg"]
    errors = ", ".join(
        f"{error['w >= 0'][name]:.1f} to {error['both'][name]:.1f} deg on {robot_title(name)}"
        for name in ROBOTS
    )
    verdict = "holds" if holds else "does not hold"
    return table, (
        f"With both signs the former loss's gradient is {ratio.min():.2f} to {ratio.max():.2f} "
        f"times as large on average: the claim that it explodes {verdict} (asked: {FACTOR:g}); "
        f"its rotation error goes from {errors}."
    )
