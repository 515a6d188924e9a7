"""A results folder that looks like a run's, made of drawn numbers: nothing in it was measured."""

from pathlib import Path

import numpy as np
import pandas as pd

from pipeline.data.files import write_json, write_sealed_yaml
from pipeline.data.tables import write_table
from pipeline.evaluation.config import Tolerance
from pipeline.reporting.config import LeaderboardConfig, ReportConfig, SuccessConfig

# Median error [mm], spread, share unsolved, time [us], iterations: plausible, not real.
SOLVERS = {
    "cycleik": (7.0, 0.9, 0.0, 150.0, 1),
    "pinocchio": (0.02, 0.8, 0.02, 900.0, 30),
    "placo": (0.015, 0.8, 0.04, 350.0, 9),
    "lm": (0.01, 0.9, 0.0005, 60.0, 14),
    "trac_ik": (0.002, 0.7, 0.14, 500.0, 20),
}
HARDNESS = {"panda": 1.4, "nico": 0.7, "nicol": 0.4, "valkyrie": 0.6, "fetch": 0.9}
PUBLISHED = Path(__file__).parents[3] / "results" / "published_results.csv"


def report_config(**changes):
    loose = Tolerance(position_mm=10.0, rotation_deg=20.0)
    success = SuccessConfig(Tolerance(position_mm=1.0, rotation_deg=1.0), loose, loose)
    values = {
        "title": "A report",
        "not_found": "idle",
        "success": success,
        "confidence": 0.95,
        "resamples": 100,
        "seed": 0,
        "dpi": 100,
        "embed_mb": 5.0,
        "leaderboard": LeaderboardConfig(shift_us=10.0, within_us=[10.0, 100.0, 1000.0]),
    }
    return ReportConfig(**{**values, **changes})


def raw_rows(robot="panda", solver="cycleik", poses=200, seed=0, batch_size=1):
    generator = np.random.default_rng([seed, len(robot), len(solver)])
    median, spread, unsolved, time, iterations = SOLVERS[solver]
    error = median * HARDNESS[robot] * np.exp(generator.normal(0, spread, poses))
    angle = error * 0.25 * np.exp(generator.normal(0, 0.4, poses))
    missed = generator.random(poses) < unsolved
    error, angle = np.where(missed, 120.0, error), np.where(missed, 60.0, angle)
    found = (error < 10) & (angle < 20)
    position = np.random.default_rng(99).uniform(-0.6, 0.8, (poses, 3))
    shared = time / batch_size**0.4 if solver in ("cycleik", "lm") else time
    return pd.DataFrame(
        {
            "robot": robot,
            "solver": solver,
            "seed": 0,
            "pose": np.arange(poses),
            "batch_size": batch_size,
            "found": found,
            "answered": found | (solver == "cycleik"),
            "reason": np.where(found, "", "out of time"),
            "position_error_mm": error,
            "rotation_error_deg": angle,
            "paper_position_error_mm": error / 2,
            "paper_rotation_error_deg": angle / 2,
            "idle_position_error_mm": 700.0,
            "idle_rotation_error_deg": 110.0,
            "paper_idle_position_error_mm": 350.0,
            "paper_idle_rotation_error_deg": 55.0,
            "within_limits": True,
            "claimed_and_wrong": False,
            "time_per_pose_us": shared * np.exp(generator.normal(0, 0.2, poses)),
            "solver_time_us": shared * 0.8,
            "iterations": iterations,
            "target_x_m": position[:, 0],
            "target_y_m": position[:, 1],
            "target_z_m": position[:, 2] + 0.5,
            "seeded_by": "home",
            "seed_time_us": 0.0,
            "threads": 1,
            "pinned": True,
            "machine": "0123abcd",
        }
    )


def write_results(root, robots=("panda", "nico"), solvers=tuple(SOLVERS), poses=200):
    """Write what all stages would leave in a results folder."""
    for robot in robots:
        for solver in solvers:
            batches = (1, 100, 1000) if solver in ("cycleik", "lm") else (1,)
            parts = [
                raw_rows(robot, solver, poses if b == 1 else poses // 2, batch_size=b)
                for b in batches
            ]
            machine = {"processor": "A processor", "cores": 2, "system": "Linux x86_64"}
            facts = {"commit": "abc123", "machine": machine, "evaluate": {"chunk": 100}}
            facts |= {"solver_budget": {"time_s": 0.1, "iterations": None}}
            rows = pd.concat(parts, ignore_index=True)
            write_table(root / "evaluate" / robot / f"{solver}.parquet", rows, facts)
        _write_training(root, robot)
        _write_dataset(root, robot)
        _write_plan(root, robot)
        _write_grasp(root, robot)
    _write_tune(root, robots[-1])
    return root


def _write_training(root, robot):
    steps = np.linspace(1, 8000, 400).astype(int)
    generator = np.random.default_rng(1)
    error = 8 * HARDNESS[robot] + 300 * np.exp(-steps / 700)
    noisy = error * np.exp(generator.normal(0, 0.15, len(steps)))
    validated = np.where(np.arange(len(steps)) % 20 == 19, error * 1.05, np.nan)
    curve = pd.DataFrame(
        {
            "step": steps,
            "samples": steps * 500,
            "loss": noisy / 50,
            "position_error_mm": noisy,
            "rotation_error_deg": noisy / 4,
            "validation_position_error_mm": validated,
            "validation_rotation_error_deg": validated / 4,
            "learning_rate": 1e-3 * (1 - steps / 8000),
        }
    )
    folder = root / "train" / robot / "compact"
    folder.mkdir(parents=True)
    curve.to_csv(folder / "curve.csv", index=False)
    train = {"batch_size": 500, "learning_rate": 1e-3, "position_weight": 16.0, "loss": "smooth"}
    card = {
        "parameters": 612_345,
        "device": "cpu",
        "commit": "abc123",
        "versions": {"python": "3.11.7", "torch": "2.13.0"},
        "validation": {
            "position_error_mm": error[-1],
            "rotation_error_deg": error[-1] / 4,
            "success_10mm_20deg": 0.6,
            "skipped_steps": 0,
        },
        "config": {
            "train": {**train, "rotation_weight": 2.0},
            "model": {"name": "compact", "hidden": [384] * 4, "tanh_layers": 1},
        },
    }
    write_json(folder / "card.json", card)


def _write_dataset(root, robot):
    sizes = (("train", 200_000), ("validation", 10_000), ("test", 5_000))
    splits = {
        name: {"poses": n, "acceptance": 0.71, "in_collision": n // 3, "seed": 12345}
        for name, n in sizes
    }
    write_json(root / "dataset" / robot / "card.json", {"splits": splits, "commit": "abc123"})


def _write_plan(root, robot):
    generator = np.random.default_rng(2)
    frames = []
    for solver, (time, error, flips) in {
        "cycleik": (2.5, 9.0, 0.01),
        "placo": (18.0, 0.05, 0.12),
    }.items():
        count = 60
        largest = error * np.exp(generator.normal(0, 0.5, count))
        frames.append(
            pd.DataFrame(
                {
                    "robot": robot,
                    "solver": solver,
                    "pair": np.arange(count),
                    "plan_time_ms": time * np.exp(generator.normal(0, 0.2, count)),
                    "tip_error_mm": largest,
                    "tip_error_mean_mm": largest / 2,
                    "largest_step_rad": generator.uniform(0.05, 0.4, count),
                    "flips": (generator.random(count) < flips).astype(int),
                }
            )
        )
    write_table(root / "plan" / robot / "plans.parquet", pd.concat(frames), {})


def _write_grasp(root, robot):
    classes = ["Success"] * 17 + ["Slipped"] * 2 + ["Not Grasped"]
    trials = pd.DataFrame({"trial": range(20), "robot": robot, "class": classes})
    trials["object"] = [("pear", "soup_can")[k % 2] for k in range(20)]
    trials["row"], trials["approach_plan_ms"] = trials.trial // 5, 1.0
    trials["x_m"], trials["y_m"] = 0.3 + 0.05 * trials.row, 0.1 * (trials.trial % 5) - 0.2
    write_table(root / "grasp" / robot / "trials.parquet", trials, {})
    for study, axes in (("solver", "solver"), ("grip", "friction_scale,tension_scale")):
        rows = trials.assign(study=study, axes=axes, solver="lm")
        rows["friction_scale"], rows["tension_scale"] = 0.5 + rows.trial % 2, 1.0 + rows.row % 2
        write_table(root / "grasp_study" / robot / f"{study}.parquet", rows, {})


def _write_tune(root, robot):
    folder = root / "tune" / robot
    folder.mkdir(parents=True)
    pd.DataFrame({"number": range(8), "value": np.linspace(1, 0.3, 8)}).to_csv(
        folder / "trials.csv", index=False
    )
    write_sealed_yaml(
        folder / "best.yaml",
        "train: {batch_size: 300, learning_rate: 0.002, position_weight: 9, rotation_weight: 3}\n"
        "model: {hidden: [448, 320], tanh_layers: 1}\n",
    )
