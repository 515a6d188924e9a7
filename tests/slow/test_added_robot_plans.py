"""A robot that was added a moment ago plans motions: no further file is written for it."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from pipeline.data.tables import read_table
from tests.unpacked import unpack

DATA = Path(sysconfig.get_path("purelib")) / "cmeel.prefix/share/example-robot-data/robots"
pytestmark = pytest.mark.slow  # a copy of the project compiles its kernels anew
UR5 = DATA / "ur_description" / "urdf" / "ur5_robot.urdf"
SMALL = [
    "robot=guest",
    "profile=smoke",
    "dataset.train=300",
    "dataset.validation=30",
    "dataset.test=30",
    "dataset.workers=1",
    "train.epochs=2",
    "plan.pairs=2",
    "plan.solvers=[cycleik,lm]",
]


def call(checkout: Path, *arguments: str) -> str:
    """Run the command line of a copy of the project."""
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "pipeline", *arguments]
    done = subprocess.run(
        command, cwd=checkout, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.mark.skipif(not UR5.exists(), reason="needs example-robot-data")
def test_a_robot_that_was_just_added_plans(tmp_path: Path) -> None:
    checkout = unpack(tmp_path / "project")  # robots are added to the checkout that runs
    where = ["--base", "base_link", "--tip", "tool0", "--name", "guest"]
    assert "added robot 'guest'" in call(checkout, "robot", "add", str(UR5), *where)
    results = tmp_path / "results"
    call(checkout, "plan", *SMALL, f"results_dir={results}")
    rows = read_table(results / "plan" / "guest" / "plans.parquet")
    assert sorted(rows["solver"].unique()) == ["cycleik", "lm"]
    assert len(rows) >= 4
    assert (rows["waypoints_found"] > 0).any()
    assert (results / "plan" / "guest" / "path.png").stat().st_size > 0
