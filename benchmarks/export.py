"""What a pose costs in each kind of exported file, beside the solver that it came from.

    python -m benchmarks.export [--robots panda ...] [--poses 10000] [--write]

Prints two Markdown tables. The first: microseconds a pose on one core, the median of rounds in
which all take turns, for calls of one pose and of a thousand; C has no batches, so that both of its
columns are a loop over poses. The second: largest differences over all poses from the solver and
from the network evaluated in float64, with ties; forward kinematics; how many poses the descent
finds beside ours, and its largest errors recomputed by Pinocchio.
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import torch
from numpy.typing import NDArray

from baselines import Solver
from benchmarks.query import markdown
from benchmarks.studies import write_study
from pipeline import load_solver
from pipeline.config import compose
from pipeline.evaluation.verification import tip_poses
from pipeline.exporting.c_compiler import CompiledHeader
from pipeline.exporting.comparison import compare
from pipeline.exporting.config import ExportConfig
from pipeline.exporting.source import Source, card_of, load_source
from pipeline.exporting.targets import TARGETS
from pipeline.learning.card import shipped_weights
from pipeline.settings import Config
from robots import Robot, available_robots, load_robot, rotations

Array = NDArray[np.float64]
Answers = Callable[[Array], object]
Rows = list[list[str]]

SEED = 1
BATCH = 1000
ROUNDS = 15
SINGLE = 200  # poses of a round of calls of one pose
NATIVE = ("-std=c99", "-O3", "-march=native")
TEXT = (
    "Exported files beside the solver that they came from, one core, the compact network that "
    "comes with the project;\nmicroseconds are medians of rounds in turns, differences those from "
    "the solver `cycleik`\nand from the network evaluated in float64 [rad or m]."
)


def arguments() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=available_robots())
    parser.add_argument("--poses", type=int, default=10_000)
    parser.add_argument("--write", action="store_true", help="also into results/studies")
    return parser.parse_args()


def written(source: Source, config: ExportConfig, folder: Path) -> dict[str, Path]:
    """Write a file of each target that can be read here."""
    paths = {}
    for name, target in TARGETS.items():
        if reason := target.unreadable():
            print(f"left out: {name} ({reason})")
            continue
        paths[name] = folder / f"ik{target.suffix}"
        card = {"file": paths[name].name, **card_of(source, "python -m benchmarks.export")}
        target.write(paths[name], source, config, card)
    return paths


def medians(answers: dict[str, Answers], poses: Array, size: int) -> dict[str, float]:
    """Microseconds a pose of each, called with so many poses, in turns."""
    spent: dict[str, list[float]] = {name: [] for name in answers}
    batches = [poses[k : k + size] for k in range(0, len(poses) - size + 1, size)]
    batches = batches[: SINGLE if size == 1 else 1]
    for turn in range(ROUNDS + 1):
        for name, answer in answers.items():
            start = time.perf_counter()
            for batch in batches:
                answer(batch)
            if turn:  # the first warms up
                spent[name].append(1e6 * (time.perf_counter() - start) / len(batches) / size)
    return {name: float(np.median(values)) for name, values in spent.items()}


def solver_answers(solver: Solver) -> Answers:
    """One call of `solve` for a batch, of `solve_one` for a pose."""

    def answer(poses: Array) -> object:
        return solver.solve_one(poses[0]) if len(poses) == 1 else solver.solve(poses)

    return answer


def times(robot: Robot, answers: dict[str, Answers], c: set[str], poses: Array) -> Rows:
    """Rows of the first table."""
    batch = medians(answers, poses, BATCH)
    single = medians({name: each for name, each in answers.items() if name not in c}, poses, 1)
    return [
        [robot.name, name, f"{single.get(name, batch[name]):.2f}", f"{batch[name]:.2f}"]
        for name in answers
    ]


def descent_cells(
    robot: Robot, header: CompiledHeader, refined: Solver, joints: Array
) -> list[str]:
    """Cells of kinematics and descent in C: differences, what is found, errors by Pinocchio."""
    poses = robot.forward_kinematics(joints)
    off = np.abs(header.forward_kinematics(joints) - poses).max()
    answers, found = header.solve(poses)
    reached, targets = tip_poses(robot, answers[found]), poses[found]
    distance = 1e3 * np.linalg.norm(reached[:, :3] - targets[:, :3], axis=1)
    angle = np.degrees(rotations.rotation_angle(reached[:, 3:], targets[:, 3:]))
    ours = refined.solve(poses).found
    errors = f"{distance.max(initial=0.0):.4f} mm, {angle.max(initial=0.0):.4f} deg"
    return [f"{off:.1e}", f"{found.sum()} / {ours.sum()}", errors]


def study(robot: Robot, count: int, config: Config) -> tuple[Rows, Rows]:
    """Rows of both tables for one robot."""
    filtered = config.robot.workspace_filter
    joints = robot.sample(count, seed=SEED, collision_free=False, workspace_filter=filtered)
    poses = robot.forward_kinematics(joints)
    source = load_source(robot, shipped_weights(robot.name))
    solvers = {name: load_solver(name, robot, threads=1) for name in ("cycleik", "cycleik_refined")}
    refined = solvers["cycleik_refined"]
    answers = {name: solver_answers(solver) for name, solver in solvers.items()}
    differences, in_c = [], set()
    with tempfile.TemporaryDirectory() as folder:
        for name, path in written(source, config.export, Path(folder)).items():
            if name == "c":
                header = CompiledHeader(source, path, NATIVE)
                answers |= {"c, network": header.network, "c, solve": header.solve}
                in_c = {"c, network", "c, solve"}
                given = header.network(poses)[0]
                descent = descent_cells(robot, header, refined, joints)
            else:
                answer = answers[name] = TARGETS[name].read(source, path, config.export)
                given, descent = np.asarray(answer(poses)), ["", "", ""]
            seen = compare(source, poses, given, config.export.tie)
            cells = [
                f"{seen.from_solver:.1e}",
                seen.solver_other,
                f"{seen.largest:.1e}",
                seen.ties,
                seen.other,
            ]
            differences.append([robot.name, name, *map(str, cells), *descent])
    return times(robot, answers, in_c, poses), differences


def main() -> None:
    """Print both tables."""
    options = arguments()
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    torch.set_num_threads(1)
    spent, differences = [], []
    for name in options.robots:
        rows = study(load_robot(name), options.poses, compose([f"robot={name}"]))
        spent += rows[0]
        differences += rows[1]
    columns = ("from the solver", "solver, other head", "from float64", "ties", "other head")
    first = pd.DataFrame(spent, columns=["robot", "what", "one pose us", f"batch of {BATCH} us"])
    second = pd.DataFrame(
        differences,
        columns=["robot", "file", *columns, "fk", "found / ours", "largest errors"],
    )
    text = f"{TEXT}\n\n{markdown(first)}\n\n{options.poses} poses a robot:\n\n{markdown(second)}"
    print(text)
    if options.write:
        table = first.merge(
            second.assign(what=second["file"].replace("c", "c, network")).drop(columns="file"),
            on=["robot", "what"],
            how="left",
        )
        command = f"python -m benchmarks.export --poses {options.poses} --write"
        write_study("export", table, text, command, str(SEED))


if __name__ == "__main__":
    main()
