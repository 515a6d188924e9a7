"""Claim `labels_fail`: joint angles as labels train badly for redundant arms, the cycle does not.

The same network, poses and steps: mean squared error to the joints that a pose was made from, in
shares of their ranges, against the paper's losses through forward kinematics. It holds if on every
arm of more than six joints the labels end with at least five times the position error of the cycle.
"""

from __future__ import annotations

import pandas as pd
from torch import Tensor

from benchmarks.claims.fitting import CPU, Batch, fit, pose_sets, recipe, small_network
from pipeline.learning.cycleik.objective import CycleObjective
from pipeline.learning.networks import IkNetwork
from robots import load_robot

NAME, SEEDS = "claim_labels", "of weights and order 0; of poses 0 and 1"
FACTOR = 5.0
ROBOTS = ("nico", "panda", "valkyrie", "nicol", "fetch")


def label_loss(network: IkNetwork, batch: Batch) -> Tensor:
    """Mean squared error of joints, each in halves of its range."""
    answers = network(batch.poses)[:, 0]
    return ((answers - batch.joints) / network.joint_scale).square().mean()


def run() -> tuple[pd.DataFrame, str]:
    """Train both ways for each robot; rows and the verdict."""
    rows = []
    for name in ROBOTS:
        robot = load_robot(name)
        train, data = recipe(robot, "train.epochs=10"), pose_sets(robot)
        cycle = CycleObjective(robot, small_network(robot, 0), train, CPU)

        def cycle_loss(network: IkNetwork, batch: Batch, cycle: CycleObjective = cycle) -> Tensor:
            cycle.network = network
            return cycle.loss_of(batch.poses, batch.poses)

        for target, loss in (("labels", label_loss), ("cycle", cycle_loss)):
            ended = fit(robot, train, loss, data, seed=0)
            rows.append(
                {
                    "robot": name,
                    "joints": robot.dof,
                    "target": target,
                    "position_mm": ended.position_mm,
                    "rotation_deg": ended.rotation_deg,
                }
            )
    table = pd.DataFrame(rows)
    wide = table[table.joints > 6].pivot(index="robot", columns="target", values="position_mm")
    ratio = wide.labels / wide.cycle
    holds = bool((ratio >= FACTOR).all())
    return table, (
        f"On arms of more than six joints labels end with {ratio.min():.1f} to {ratio.max():.1f} "
        f"times the position error of the cycle: the claim {'holds' if holds else 'does not hold'} "
        f"(asked: {FACTOR:g} on each)."
    )
