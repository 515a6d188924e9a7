"""Claim `ten_epochs`: the new losses are precise after ten epochs, the former needed 100 to 300.

A small network of the paper's kind and 100,000 poses. Equal weights would favour one loss, since
the new rotation loss sums four components and the former averages them: each loss has its own best
weights and rate of the same nine draws, chosen by ten epochs at the paper's fixed weighing of both
errors (10 for metres, 1 for radians here). Then three seeds of each: new at 10 epochs, former at 10
and at 100. It holds on a robot if the new loss after 10 epochs is at least as precise as the former
after 100 by that measure (mean of three seeds), and altogether if it does on both robots.
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

from benchmarks.claims.fitting import TRAINING, Fit, fit, pose_sets
from pipeline.presentation.naming import robot_title
from robots import load_robot

NAME = "claim_epochs"
SEEDS = "of weights and order 0 to 2, in the search 9; of poses 0 and 1; of draws 5"
ROBOTS = ("nico", "panda")
DRAWS, DRAWS_SEED, SEARCH_SEED = 9, 5, 9
POSITION_WEIGHTS, ROTATION_WEIGHTS, RATES = (1, 20), (1, 20), (3e-4, 3e-3)
RUNS = (("smooth", 10), ("former", 10), ("former", 100))


def score(ended: Fit) -> float:
    """The paper's fixed weighing of both errors: 10 for m and 1 for rad."""
    return 10e-3 * ended.position_mm + math.radians(ended.rotation_deg)


def draws() -> list[list[str]]:
    """Weights and rates, the same for both losses."""
    generator = np.random.default_rng(DRAWS_SEED)

    def drawn(low: float, high: float) -> float:
        return float(np.exp(generator.uniform(np.log(low), np.log(high))))

    return [
        [
            f"train.position_weight={drawn(*POSITION_WEIGHTS):.3g}",
            f"train.rotation_weight={drawn(*ROTATION_WEIGHTS):.3g}",
            f"train.learning_rate={drawn(*RATES):.3g}",
        ]
        for _ in range(DRAWS)
    ]


def run() -> tuple[pd.DataFrame, str]:
    """Choose weights, train three seeds of each; rows and the verdict."""
    rows = []
    for name in ROBOTS:
        robot = load_robot(name)
        data = pose_sets(robot)
        best = {}
        for loss in ("smooth", "former"):
            ten = (f"train.loss={loss}", "train.epochs=10")
            tried = [(each, fit(robot, data, SEARCH_SEED, *ten, *each)) for each in draws()]
            rows += [_row(name, "search", loss, 10, SEARCH_SEED, *each) for each in tried]
            best[loss] = min(tried, key=lambda each: score(each[1]))[0]
        for loss, epochs in RUNS:
            for seed in range(3):
                recipe = (f"train.loss={loss}", f"train.epochs={epochs}", *best[loss])
                ended = fit(robot, data, seed, *recipe)
                rows.append(_row(name, "contest", loss, epochs, seed, best[loss], ended))
    table = pd.DataFrame(rows)
    contest = table[table.part == "contest"]
    means = contest.groupby(["robot", "loss", "epochs"])[["score", "position_mm", "rotation_deg"]]
    mean = means.mean()
    sentences, holds = [], True
    for name in ROBOTS:
        new, old = mean.loc[name, "smooth", 10], mean.loc[name, "former", 100]
        holds &= bool(new.score <= old.score)
        short = mean.loc[name, "former", 10]
        sentences.append(
            f"{robot_title(name)}: new at 10 epochs {new.position_mm:.1f} mm and "
            f"{new.rotation_deg:.2f} deg, former at 10 {short.position_mm:.1f} mm and "
            f"{short.rotation_deg:.2f} deg, at 100 {old.position_mm:.1f} mm and "
            f"{old.rotation_deg:.2f} deg"
        )
    verdict = "holds" if holds else "does not hold"
    return table, f"{'; '.join(sentences)}: the claim {verdict} ({TRAINING:,} poses)."


def _row(
    robot: str, part: str, loss: str, epochs: int, seed: int, drawn: list[str], ended: Fit
) -> dict[str, object]:
    pairs = (each.removeprefix("train.").split("=") for each in drawn)
    values = {key: float(value) for key, value in pairs}
    return {
        "robot": robot,
        "part": part,
        "loss": loss,
        "epochs": epochs,
        "seed": seed,
        **values,
        "position_mm": ended.position_mm,
        "rotation_deg": ended.rotation_deg,
        "score": score(ended),
    }
