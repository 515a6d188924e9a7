"""The evaluate stage killed (SIGKILL) again and again: finished chunks are kept, rows are whole."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from pipeline.config import compose
from pipeline.data.tables import TableError, read_metadata, read_table
from pipeline.stages.running import run_stage

POSES, CHUNK, KILLS = 400, 20, 2
ARGUMENTS = [
    "robot=nico",
    "profile=smoke",
    "dataset.train=60",
    "dataset.validation=30",
    f"dataset.test={POSES}",
    "dataset.workers=1",
    "evaluate.solvers=[pinocchio]",
    "evaluate.poses=0",
    "evaluate.time_s=null",
    "evaluate.iterations=60",  # the same answers at any speed
    f"evaluate.chunk={CHUNK}",
]
DEADLINE_S = 120.0
TIMES = ["time_per_pose_us", "solver_time_us"]


def finished(parts: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in parts.glob("batch*.parquet")}


def kill_after(root: Path, parts: Path, count: int) -> None:
    command = [sys.executable, "-m", "pipeline", "evaluate", *ARGUMENTS, f"results_dir={root}"]
    deadline = time.monotonic() + DEADLINE_S
    with subprocess.Popen(command, stderr=subprocess.DEVNULL, stdout=subprocess.DEVNULL) as child:
        while len(finished(parts)) < count and child.poll() is None:
            assert time.monotonic() < deadline, "the stage makes no progress"
            time.sleep(0.002)
        assert child.poll() is None, "the stage ended before it could be killed"
        os.kill(child.pid, signal.SIGKILL)
    assert child.returncode == -signal.SIGKILL


def test_evaluation_killed_again_and_again_loses_a_chunk_at_most(tmp_path: Path) -> None:
    cut, whole = tmp_path / "cut", tmp_path / "whole"
    parts = cut / "checkpoint" / "evaluate-nico-pinocchio"
    table = cut / "evaluate" / "nico" / "pinocchio.parquet"
    run_stage("dataset", compose([*ARGUMENTS, f"results_dir={cut}"]))
    before: dict[str, bytes] = {}
    for kill in range(1, KILLS + 1):
        kill_after(cut, parts, 3 * kill)
        with pytest.raises(TableError):
            read_metadata(table)
        now = finished(parts)
        assert all(now[name] == content for name, content in before.items())
        before = now
    run_stage("evaluate", compose([*ARGUMENTS, f"results_dir={cut}"]))
    rows = read_table(table)
    kept = pd.concat(  # measured before the last kill: its times are those of the table
        [_part(content, tmp_path) for _, content in sorted(before.items())], ignore_index=True
    )
    assert len(kept) >= 3 * KILLS * CHUNK
    pd.testing.assert_frame_equal(rows.iloc[: len(kept)], kept)
    assert rows.pose.tolist() == list(range(POSES))
    assert not parts.exists()
    run_stage("evaluate", compose([*ARGUMENTS, f"results_dir={whole}"]))
    again = read_table(whole / "evaluate" / "nico" / "pinocchio.parquet")
    pd.testing.assert_frame_equal(rows.drop(columns=TIMES), again.drop(columns=TIMES))


def _part(content: bytes, folder: Path) -> pd.DataFrame:
    path = folder / "part.parquet"
    path.write_bytes(content)
    return read_table(path)


def test_rows_of_the_same_question_are_kept_when_asked(tmp_path: Path) -> None:
    arguments = [*ARGUMENTS, "evaluate.poses=20", f"results_dir={tmp_path}"]
    (path,) = run_stage("evaluate", compose(arguments))
    first = path.read_bytes()
    run_stage("evaluate", compose([*arguments, "evaluate.keep=true", "evaluate.first_core=1"]))
    assert path.read_bytes() == first
    path.write_bytes(first[:-50])
    run_stage("evaluate", compose([*arguments, "evaluate.keep=true"]))
    assert len(read_table(path)) == 20
    run_stage("evaluate", compose([*arguments, "evaluate.keep=true", "evaluate.iterations=50"]))
    assert read_metadata(path)["solver_budget"]["iterations"] == 50
