"""Stages end to end at toy scale: artifacts, cards, determinism, kill and resume."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pipeline.config import compose
from pipeline.data.dataset import DatasetError, read_split
from pipeline.data.tables import read_metadata, read_table
from pipeline.settings import Config
from pipeline.stages.running import run_stage
from robots import load_robot
from tests.toy import TOY

RUN = [
    *TOY,
    "train.epochs=2",
    "evaluate.latency_poses=50",
    "plan.pairs=2",
    "plan.solvers=[cycleik,placo]",
    "tune.trials=2",
]


def config(folder: Path, *overrides: str) -> Config:
    return compose([*RUN, *overrides, f"results_dir={folder}"])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A results folder with a dataset and trained weights of nico."""
    made = tmp_path_factory.mktemp("results")
    run_stage("train", config(made))
    return made


def bytes_of(folder: Path) -> dict[str, bytes]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.name: path.read_bytes() for path in files}


def test_a_dataset_is_free_of_collisions_reachable_and_independent(folder: Path) -> None:
    robot = load_robot("nico")
    splits = [
        read_split(folder / "dataset" / "nico", name, robot)
        for name in ("train", "validation", "test")
    ]
    assert [len(split.poses) for split in splits] == [600, 60, 60]
    for split in splits:
        assert not robot.in_collision(split.joints).any()
        assert (split.poses[:, 3] >= 0).all()
        np.testing.assert_allclose(robot.forward_kinematics(split.joints), split.poses, atol=1e-12)
    rows = {row.tobytes() for split in splits for row in split.joints}
    assert len(rows) == 720


def test_a_second_dataset_has_the_same_bytes(folder: Path, tmp_path: Path) -> None:
    run_stage("dataset", config(tmp_path))
    again = tmp_path / "dataset" / "nico"
    assert bytes_of(again) == bytes_of(folder / "dataset" / "nico")
    (again / "test.parquet").unlink()  # as a killed run leaves it: splits without a card
    (again / "card.json").unlink()
    run_stage("dataset", config(tmp_path))
    assert bytes_of(again) == bytes_of(folder / "dataset" / "nico")


def test_a_damaged_dataset_is_named_before_training_starts(folder: Path, tmp_path: Path) -> None:
    run_stage("dataset", config(tmp_path))
    path = tmp_path / "dataset" / "nico" / "train.parquet"
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(DatasetError, match=r"train.parquet .*pipeline dataset robot=nico"):
        run_stage("train", config(tmp_path))
    assert not (tmp_path / "train" / "nico" / "tiny" / "weights.safetensors").exists()


def test_other_sizes_are_not_silently_replaced(folder: Path) -> None:
    before = bytes_of(folder / "dataset" / "nico")
    with pytest.raises(DatasetError, match="other values of train"):
        run_stage("train", config(folder, "dataset.train=700"))
    assert bytes_of(folder / "dataset" / "nico") == before


def test_training_leaves_weights_card_curve_and_no_checkpoint(folder: Path) -> None:
    made = folder / "train" / "nico" / "tiny"
    card = json.loads((made / "card.json").read_text())
    assert card["robot"] == "nico"
    assert card["config"]["train"]["epochs"] == 2
    assert card["versions"]["torch"]
    curve = pd.read_csv(made / "curve.csv")
    assert curve["step"].iloc[-1] == 12
    assert curve["validation_position_error_mm"].notna().all()
    assert not list((folder / "checkpoint").glob("*.safetensors"))


def test_training_twice_gives_the_same_weights(folder: Path, tmp_path: Path) -> None:
    run_stage("train", config(tmp_path))
    first, second = (bytes_of(root / "train" / "nico" / "tiny") for root in (folder, tmp_path))
    assert first["weights.safetensors"] == second["weights.safetensors"]
    assert first["curve.csv"] == second["curve.csv"]


def test_training_that_is_killed_goes_on_and_ends_with_the_same_bytes(tmp_path: Path) -> None:
    """SIGKILL in the middle, as a power cut would; the next call resumes from the checkpoint."""
    long = ["train.epochs=120", "train.checkpoint_s=0.02"]
    whole, cut = tmp_path / "whole", tmp_path / "cut"
    run_stage("train", config(whole, *long))
    command = [sys.executable, "-m", "pipeline", "train", *RUN, *long, f"results_dir={cut}"]
    checkpoint = cut / "checkpoint" / "nico-tiny.safetensors"
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as child:
        deadline = time.monotonic() + 60
        while not checkpoint.exists() and child.poll() is None and time.monotonic() < deadline:
            time.sleep(0.01)
        assert child.poll() is None, "the training ended before it could be killed"
        os.kill(child.pid, signal.SIGKILL)
    assert checkpoint.exists()
    assert not (cut / "train" / "nico" / "tiny" / "card.json").exists()
    run_stage("train", config(cut, *long))
    first, second = (bytes_of(root / "train" / "nico" / "tiny") for root in (whole, cut))
    assert first["weights.safetensors"] == second["weights.safetensors"]
    assert first["curve.csv"] == second["curve.csv"]
    assert not checkpoint.exists()


def test_evaluation_writes_one_row_a_pose_with_true_errors(folder: Path) -> None:
    settings = config(folder, "evaluate.solvers=[cycleik,placo]")
    paths = run_stage("evaluate", settings)
    robot = load_robot("nico")
    poses = read_split(folder / "dataset" / "nico", "test", robot).poses
    for path in paths:
        rows = read_table(path)
        single = rows[rows["batch_size"] == 1]
        assert single["pose"].tolist() == list(range(60))
        joints = single[[f"q{i}" for i in range(robot.dof)]].to_numpy()
        reached = robot.forward_kinematics(joints)
        expected = 1e3 * np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
        np.testing.assert_allclose(single["position_error_mm"], expected, atol=1e-6)
        assert read_metadata(path)["robot"] == "nico"


def test_a_search_has_the_asked_trials_and_goes_on_to_more(folder: Path, tmp_path: Path) -> None:
    run_stage("tune", config(folder))
    first = pd.read_csv(folder / "tune" / "nico" / "trials.csv")
    assert first["state"].tolist() == ["COMPLETE"] * 2
    run_stage("tune", config(folder, "tune.trials=3"))
    second = pd.read_csv(folder / "tune" / "nico" / "trials.csv")
    assert len(second) == 3
    pd.testing.assert_frame_equal(second[: len(first)][first.columns], first)
    assert second["learning_rate"].nunique() == 3
    shutil.copytree(folder / "tune", tmp_path / "tune")
    run_stage("train", config(tmp_path, "train.from=best"))
    card = json.loads((tmp_path / "train" / "nico" / "tiny" / "card.json").read_text())
    best = second.loc[second["objective"].idxmin()]
    assert card["config"]["train"]["learning_rate"] == best["learning_rate"]


def test_plans_have_fifty_waypoints_and_honest_errors(folder: Path) -> None:
    (made,) = run_stage("plan", config(folder))
    rows = read_table(made / "plans.parquet")
    assert sorted(rows["solver"].unique()) == ["cycleik", "placo"]
    assert (rows["waypoints"] == 50).all()
    assert (rows["limit_violations"] == 0).all()
    placo, network = (
        rows.loc[rows["solver"] == name, "query_tip_error_mean_mm"]  # before any repair
        for name in ("placo", "cycleik")
    )
    assert placo.mean() < network.mean()
    assert (made / "path.png").stat().st_size > 10_000


def test_the_report_is_a_function_of_the_rows(folder: Path) -> None:
    run_stage("evaluate", config(folder, "evaluate.solvers=[cycleik,placo]"))
    run_stage("report", config(folder))
    first = bytes_of(folder / "tables") | bytes_of(folder / "figures")
    page = (folder / "report.html").read_text()
    assert 'src="http' not in page
    assert "97.31" in page  # the paper's success on NICO stands beside ours
    run_stage("report", config(folder))
    assert bytes_of(folder / "tables") | bytes_of(folder / "figures") == first
