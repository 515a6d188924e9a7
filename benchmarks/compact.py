"""The compact network against the paper's: errors on 200,000 poses, by experts that answer a pose.

    python -m benchmarks.compact [--robots nicol ...] [--cells 1 2] [--poses 200000]
                                 [--weights nicol=FOLDER ...] [--write]

The poses are those of the robot's test set at that size; errors are the paper's, means over the
axes, and success is below 10 mm and 20 deg of these. Every network answers twice: the best of its
hypotheses is the one whose errors are least in units of 10 mm and 20 deg, or of 10 mm and 4 deg,
which gives rotations more weight (`solver.cycleik.rotation_tolerance_deg=4`). Time: a batch of
1000 on one thread, the median of 15. `--weights` adds networks that were trained here, `--write`
writes results/studies/compact.{csv,md}.
"""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Iterator
from statistics import median
from time import perf_counter
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from baselines import Solver
from benchmarks.bio_ik_budget import SUCCESS_DEG, SUCCESS_MM
from benchmarks.studies import write_study
from pipeline import load_solver
from pipeline.config import compose
from pipeline.data.dataset import split_seed
from pipeline.evaluation.metrics import pose_errors, within
from pipeline.locations import published_results
from pipeline.presentation.naming import robot_title
from pipeline.presentation.published import read_published
from robots import load_robot

Array = NDArray[np.float64]

ROBOTS = ("nicol", "nico", "valkyrie", "panda", "fetch")
RANKED_DEG = (20.0, 4.0)
ERRORS = {"position_mm": "position", "rotation_deg": "rotation"}
BATCH, REPEATS = 1000, 15
SHIPPED = "shipped"
PAPER_TABLE = "numerical_comparison"
PUBLISHED = {
    "position_mm": "position_error_mean",
    "rotation_deg": "rotation_error_mean",
    "success": "success_rate",
}
COLUMNS = {
    "robot": "Robot",
    "network": "network",
    "cells": "experts a pose",
    "ranked_deg": "ranked by 10 mm and [deg]",
    "position_mm": "position [mm]",
    "paper_position_mm": "paper",
    "rotation_deg": "rotation [deg]",
    "paper_rotation_deg": "paper's",
    "success": "success [%]",
    "paper_success": "published",
    "below": "at most the paper's",
    "us": "a pose [us]",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", choices=ROBOTS, default=list(ROBOTS))
    parser.add_argument("--cells", nargs="+", type=int, default=[1, 2])
    parser.add_argument("--poses", type=int, default=200_000)
    parser.add_argument("--weights", nargs="+", default=[], help="robot=folder: a network more")
    parser.add_argument("--write", action="store_true", help="into results/studies")
    options = parser.parse_args()
    further = [pair.partition("=")[::2] for pair in options.weights]
    if unknown := {robot for robot, folder in further if robot not in ROBOTS or not folder}:
        parser.error(f"--weights takes robot=folder, got {', '.join(sorted(unknown))}")
    rows = []
    for name in options.robots:
        networks = ["", *(folder for robot, folder in further if robot == name)]
        for row in rows_of(name, networks, options.cells, options.poses):
            print(row, flush=True)
            rows.append(row)
    table = pd.DataFrame(rows)
    shown = table.assign(robot=table.robot.map(robot_title))[list(COLUMNS)]
    text = shown.rename(columns=COLUMNS).to_markdown(index=False, floatfmt=".4g")
    print(text)
    if options.write:
        command = shlex.join(["python", "-m", "benchmarks.compact", *sys.argv[1:]])
        which = "compact (ours), as each row says"
        write_study("compact", table, text, command, str(compose().seed), networks=which)


def rows_of(
    name: str, networks: list[str], cells: list[int], count: int
) -> Iterator[dict[str, object]]:
    """Rows of a robot: of its shipped network ("") and of others, named by their folders."""
    config = compose([f"robot={name}"])
    robot = load_robot(name)
    poses = robot.forward_kinematics(
        robot.sample(
            count,
            seed=split_seed(config.seed, name, "test"),
            workspace_filter=config.robot.workspace_filter,
        )
    )
    published = read_published(published_results())
    paper = {
        f"paper_{key}": published.number(PAPER_TABLE, name, "cycleik", metric) or np.nan
        for key, metric in PUBLISHED.items()
    }
    for folder in networks:
        for number in cells:
            for angle in RANKED_DEG:
                settings: dict[str, Any] = {"cells": number, "rotation_tolerance_deg": angle}
                settings |= {"weights": folder} if folder else {}
                solver = load_solver("cycleik", robot, threads=1, **settings)
                found = measured(solver, poses)
                what = {"robot": name, "network": folder or SHIPPED, "cells": number}
                below = [key for key in ERRORS if found[key] <= paper[f"paper_{key}"]]
                which = " and ".join(ERRORS[key] for key in below) or "none"
                yield {**what, "ranked_deg": angle, "poses": count, **found, **paper} | {
                    "below": which
                }


def measured(solver: Solver, poses: Array) -> dict[str, float]:
    """Mean errors, success and the time of a pose."""
    reached = solver.robot.forward_kinematics(solver.solve(poses).joints)
    errors = pose_errors(poses, reached)
    position, rotation = errors.paper_position_mm, errors.paper_rotation_deg
    spent = []
    for _ in range(REPEATS):
        began = perf_counter()
        solver.solve(poses[:BATCH])
        spent.append(perf_counter() - began)
    return {
        "position_mm": position.mean(),
        "rotation_deg": rotation.mean(),
        "success": 100 * within(position, rotation, SUCCESS_MM, SUCCESS_DEG).mean(),
        "us": 1e6 * median(spent) / min(BATCH, len(poses)),
    }


if __name__ == "__main__":
    main()
