"""One solver object, many callers: threads, copies, pickles, processes however they start."""

import copy
import os
import pickle
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import baselines
from baselines import Budget
from baselines.registry import settings
from robots import Robot, load_robot
from tests.small_arms import arm, save

NAMES = tuple(name for name in baselines.names() if "weights" not in settings(name))
ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="module")
def poses(panda: Robot) -> np.ndarray:
    return panda.forward_kinematics(panda.sample(60, seed=5))


@pytest.mark.parametrize("name", NAMES)
def test_threads_get_what_one_would(name: str, panda: Robot, poses: np.ndarray) -> None:
    if reason := baselines.skip(name, panda):
        pytest.skip(reason)
    solver = baselines.load(name, panda)
    counted = "iterations" in solver.budgets
    budget = Budget(iterations=100) if counted else Budget(time_s=0.05)
    halves = [poses[::2], poses[1::2]]
    alone = [solver.solve(half, budget=budget) for half in halves]
    together = threading.Barrier(2)

    def work(half: np.ndarray) -> baselines.Solution:
        together.wait()
        return solver.solve(half, budget=budget)

    with ThreadPoolExecutor(2) as pool:
        for half, one, other in zip(halves, alone, pool.map(work, halves), strict=True):
            if counted:
                assert np.array_equal(one.joints, other.joints)
            reached = panda.forward_kinematics(other.joints)
            distance = np.linalg.norm(reached[:, :3] - half[:, :3], axis=1)
            assert (distance[other.found] < 1e-3).all()


@pytest.mark.parametrize("name", NAMES)
def test_copies_and_pickles_solve_the_same(name: str, panda: Robot, poses: np.ndarray) -> None:
    if reason := baselines.skip(name, panda):
        pytest.skip(reason)
    solver = baselines.load(name, panda)
    solver.budget = Budget(iterations=40) if "iterations" in solver.budgets else solver.budget
    expected = solver.solve(poses[:6])
    for other in (
        copy.copy(solver),
        copy.deepcopy(solver),
        pickle.loads(pickle.dumps(solver)),
    ):
        assert (other.name, other.settings, other.budget) == (name, solver.settings, solver.budget)
        found = other.solve(poses[:6])
        if "iterations" in solver.budgets:
            assert np.array_equal(found.joints, expected.joints)
        assert found.found.mean() >= expected.found.mean() - 0.5


def test_collisions_of_meshes_in_threads(panda: Robot) -> None:
    nico = load_robot("nico")
    joints = nico.sample(400, collision_free=False)
    expected = nico.in_collision(joints)
    exact = nico.collision.exact
    alone = exact.in_collision(joints)
    with ThreadPoolExecutor(2) as pool:
        for _ in range(3):
            parts = pool.map(exact.in_collision, (joints[:200], joints[200:]))
            assert np.array_equal(np.concatenate(list(parts)), alone)
    assert np.array_equal(expected, nico.in_collision(joints))


def test_a_robot_needs_its_file_no_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    save(tmp_path, arm(3))
    monkeypatch.chdir(tmp_path)
    robot = load_robot(urdf="robot.urdf")
    text = pickle.dumps(robot)
    (tmp_path / "robot.urdf").unlink()
    monkeypatch.chdir("/")
    for other in (pickle.loads(text), copy.deepcopy(robot), copy.copy(robot)):
        assert np.array_equal(
            other.forward_kinematics([1, 2, 3]), robot.forward_kinematics([1, 2, 3])
        )
        assert other.in_collision([0, 0, 0]).shape == (1,)
        assert other.urdf_path.is_absolute()


PROGRAM = """
import multiprocessing, sys
import numpy as np
import baselines
from robots import load_robot

def work(number):
    robot = load_robot("panda")
    joints = robot.sample(4000, collision_free=False)
    poses = robot.forward_kinematics(joints, parallel=True)
    found = baselines.load("lm", robot, threads=0).solve(poses[:600]).joints
    return float(poses.sum()), float(found.sum()), bool(robot.in_collision(joints[:20]).any())

if __name__ == "__main__":
    here = work(0)
    if sys.argv[1] == "subprocess":
        from concurrent.futures import ProcessPoolExecutor
        with ProcessPoolExecutor(2) as pool:
            there = list(pool.map(work, range(2), timeout=100))
    else:
        with multiprocessing.get_context(sys.argv[1]).Pool(2) as pool:
            there = pool.map_async(work, range(2)).get(100)
    assert there == [here, here], (here, there)
    print("same")
"""


@pytest.mark.parametrize("method", ["fork", "spawn", "forkserver", "subprocess"])
def test_workers_do_not_hang_after_a_parallel_kernel(method: str, tmp_path: Path) -> None:
    program = tmp_path / "program.py"
    program.write_text(PROGRAM)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "NUMBA_NUM_THREADS": "2"}
    done = subprocess.run(
        [sys.executable, str(program), method],
        capture_output=True,
        text=True,
        timeout=120,
        env=environment,
        check=False,
    )
    assert done.stdout.strip() == "same", done.stderr[-500:]
