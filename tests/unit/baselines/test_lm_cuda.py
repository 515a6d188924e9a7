"""The CUDA kernels: in numba's simulator where there is no device, on one where there is."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import SettingError
from baselines.lm_cuda import LmCuda, skip
from baselines.refine import refine
from baselines.seed_library import build_seed_library
from robots import load_robot

ROOT = Path(__file__).parents[3]
SIMULATED = ROOT / "tests" / "cudasim" / "check_lm_cuda.py"


def simulate(marks: str) -> None:
    """Run the checks in a process of their own: numba chooses the simulator when imported."""
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-n", "0", "-m", marks, str(SIMULATED)],
        cwd=ROOT,
        env={**os.environ, "NUMBA_ENABLE_CUDASIM": "1"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-6000:] + done.stderr[-2000:]
    assert " passed" in done.stdout


def test_kernels_in_the_simulator_answer_as_the_cpu() -> None:
    simulate("not slow")


@pytest.mark.slow
def test_more_poses_in_the_simulator() -> None:
    simulate("slow")


@pytest.mark.skipif(skip() is None, reason="there is a CUDA device")
def test_without_a_device_it_says_so() -> None:
    robot = load_robot("panda")
    options = baselines.load("lm", robot).options(None)  # type: ignore[attr-defined]
    with pytest.raises(SettingError, match="device cuda was requested, but"):
        LmCuda(robot, options)


@pytest.mark.gpu
@pytest.mark.parametrize("name", ["panda", "nico", "valkyrie"])
def test_a_device_solves_what_the_kernel_solves(name: str) -> None:
    robot = load_robot(name)
    options = baselines.load("lm", robot).options(None)  # type: ignore[attr-defined]
    poses = robot.forward_kinematics(robot.sample(5000, seed=5, collision_free=False))
    kernel = refine(robot, poses, np.broadcast_to(robot.home, (5000, 1, robot.dof)), options)
    lanes = LmCuda(robot, options, mapping="lane").solve(poses, home=True)
    # Rounding differs, and a descent on the edge between two solutions may fall either way.
    assert (lanes.starts == kernel.starts).mean() > 0.98
    assert (np.abs(lanes.joints - kernel.joints).max(axis=1) < 1e-6).mean() > 0.98
    for mapping in ("auto", "block"):
        solver = LmCuda(robot, options, build_seed_library(robot, 2048, 6, seed=0), mapping=mapping)
        first, again = solver.solve(poses), solver.solve(poses)
        assert first.found.all()
        assert np.array_equal(first.joints, again.joints)
        reached = robot.forward_kinematics(first.joints)
        assert np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).max() <= 1.0001e-4
