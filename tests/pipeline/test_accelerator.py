"""The command for a machine with an accelerator, at toy size on the processor."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]
COMMAND = [sys.executable, "-m", "benchmarks.accelerator"]


def call(*arguments):
    return subprocess.run(
        [*COMMAND, *map(str, arguments), "--toy", "--device", "cpu"],
        cwd=ROOT,
        env={"PATH": "/usr/bin:/bin", "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.fixture(scope="module")
def poses(tmp_path_factory):
    folder = tmp_path_factory.mktemp("poses")
    made = call("data", "--data", folder, "--workers", 1)
    assert made.returncode == 0, made.stderr
    return folder


def test_table_one_leaves_rows_answers_and_weights(poses, tmp_path):
    out, weights = tmp_path / "out", tmp_path / "weights"
    done = call("train", "--data", poses, "--out", out, "--weights", weights, "--groups", "table")
    assert done.returncode == 0, done.stderr
    rows = [json.loads(line) for line in (out / "runs.jsonl").read_text().splitlines()]
    assert {row["label"] for row in rows} == {
        f"table/{name}/0" for name in ("nico", "nicol", "panda", "fetch", "valkyrie")
    }
    for row in rows:
        assert row["steps"] == row["steps_learned"]
        assert row["test"]["float32"]["poses"] == 400
        answers = np.load(out / f"answers_{row['robot']}.npy")
        assert len(answers) == 400
        assert (weights / f"{row['robot']}.safetensors").exists()
    timed = [json.loads(line) for line in (out / "latency.jsonl").read_text().splitlines()]
    assert {row["poses_per_call"] for row in timed} == {1, 100, 1000}


def test_time_that_is_over_is_said_by_name(poses, tmp_path):
    done = call(
        "train", "--data", poses, "--out", tmp_path, "--groups", "published", "--seconds", 0
    )
    assert done.returncode == 0, done.stderr
    assert "not finished in 0 s: published/nico/0" in done.stdout
