"""An installed package, run from an empty folder: it trains, evaluates, plans and loads weights."""

from __future__ import annotations

import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.unpacked import unpack

pytestmark = pytest.mark.slow
SMOKE = ("robot=panda", "profile=smoke")


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the contents of the project's wheel, before which no other copy is found."""
    folder = tmp_path_factory.mktemp("wheel")
    source = unpack(folder / "source")
    build = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation"]
    subprocess.run([*build, "-w", str(folder), str(source)], check=True, capture_output=True)
    (wheel,) = folder.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(folder / "site")
    return folder / "site"


def run(site: Path, where: Path, *command: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "PYTHONPATH": str(site), "OMP_NUM_THREADS": "1"}
    return subprocess.run(
        [sys.executable, *command],
        cwd=where,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )


def test_stages_run_and_leave_their_results_where_the_user_stands(
    installed: Path, tmp_path: Path
) -> None:
    for stage in (
        ("train", *SMOKE),
        ("evaluate", *SMOKE, "evaluate.solvers=[cycleik,lm]"),
        ("plan", *SMOKE, "plan.solvers=[cycleik]"),
        ("report", "profile=smoke"),
    ):
        done = run(installed, tmp_path, "-m", "pipeline", *stage)
        assert done.returncode == 0, done.stderr
    results = tmp_path / "results" / "smoke"
    assert (results / "train" / "panda" / "tiny" / "weights.safetensors").exists()
    assert (results / "evaluate" / "panda" / "lm.parquet").exists()
    assert (results / "report.html").exists()
    assert [path.name for path in tmp_path.iterdir()] == ["results"]


def test_weights_that_come_with_it_are_loaded(installed: Path, tmp_path: Path) -> None:
    program = (
        "import pipeline, sys\n"
        "robot = pipeline.load_robot('nico')\n"
        "solver = pipeline.load_solver('cycleik', robot)\n"
        "poses = robot.forward_kinematics(robot.sample(5))\n"
        "assert solver.solve(poses).joints.shape == (5, robot.dof)\n"
        "print(pipeline.__file__)\n"
    )
    done = run(installed, tmp_path, "-c", program)
    assert done.returncode == 0, done.stderr
    assert str(installed) in done.stdout


def test_a_whole_run_says_what_it_would_take(installed: Path, tmp_path: Path) -> None:
    done = run(installed, tmp_path, "-m", "pipeline", "all", "profile=smoke", "plan=true")
    assert done.returncode == 0, done.stderr
    assert " tasks to run, " in done.stdout
    assert not [*tmp_path.iterdir()]


def test_what_belongs_to_a_checkout_says_so(installed: Path, tmp_path: Path) -> None:
    for command in (("dvc",), ("code",), ("readme",), ("robot", "add", "a.urdf", "--base", "b")):
        done = run(installed, tmp_path, "-m", "pipeline", *command)
        assert done.returncode == 2
        assert "Traceback" not in done.stderr
    assert not [*tmp_path.iterdir()]
