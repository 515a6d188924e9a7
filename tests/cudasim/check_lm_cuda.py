"""CUDA kernels in numba's simulator against the CPU's; `test_lm_cuda` runs this in a process."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from numba import cuda

import baselines
from baselines import SettingError, lm_cuda
from baselines.lm_cuda import LmCuda
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS, LmOptions
from baselines.refine import Refined, refine
from baselines.seed_library import SeedLibrary, build_seed_library
from pipeline import load_solver
from pipeline.learning.refined import RefinedSolver
from pipeline.learning.refined_cuda import RefinedCuda
from robots import Robot, available_robots, load_robot
from robots.rotations import rotation_angle

MIXED = Path(__file__).parents[1] / "fixtures" / "mixed.urdf"
OPTIONS: LmOptions = (
    baselines.load("lm", load_robot("panda")).options(None)._replace(nearest_starts=0)  # type: ignore[attr-defined]
)  # kernels of devices have no proof that a pose is out of reach
LANES = 8  # a thread of the simulator is one of the system's


# The simulator is slow: an arm with sliding and endless joints; the others with -m slow.
QUICK = ("fetch",)


def marked(name: str) -> object:
    return name if name in QUICK else pytest.param(name, marks=pytest.mark.slow)


@pytest.fixture(scope="module", params=[marked(name) for name in available_robots()])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="module")
def library(panda: Robot) -> SeedLibrary:
    return build_seed_library(panda, 300, 6, seed=3)


def reachable(robot: Robot, count: int, seed: int = 5) -> np.ndarray:
    return robot.forward_kinematics(robot.sample(count, seed=seed, collision_free=False))


def with_restarts(robot: Robot) -> np.ndarray:
    """Poses (8, 7), three of which take the CPU a few starts: the simulator is slow with many."""
    poses = reachable(robot, 400)
    starts = refine(robot, poses, home(robot, 400)[:, :0], OPTIONS).starts
    few = (starts > 1) & (starts < 4)
    return np.concatenate((poses[starts == 1][:5], poses[few][:3]))


def home(robot: Robot, count: int) -> np.ndarray:
    return np.broadcast_to(robot.home, (count, 1, robot.dof))


def check_solved(robot: Robot, answers: Refined, poses: np.ndarray) -> None:
    assert answers.found.all()
    reached = robot.forward_kinematics(answers.joints)
    assert np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).max() <= 1.0001e-4
    assert rotation_angle(reached[:, 3:], poses[:, 3:]).max() <= 1.0001e-4
    assert (answers.joints >= robot.lower).all() and (answers.joints <= robot.upper).all()


def check_same(ours: Refined, theirs: Refined) -> None:
    assert np.array_equal(ours.status, theirs.status)
    assert np.array_equal(ours.iterations, theirs.iterations)
    assert np.array_equal(ours.starts, theirs.starts)
    np.testing.assert_allclose(ours.joints, theirs.joints, atol=1e-12, rtol=0)


def test_lanes_give_the_rows_of_the_cpu(robot: Robot) -> None:
    poses = with_restarts(robot)
    ours = LmCuda(robot, OPTIONS, mapping="lane").solve(poses)
    theirs = refine(robot, poses, home(robot, len(poses))[:, :0], OPTIONS)
    check_same(ours, theirs)
    assert theirs.starts.max() > 1
    check_same(
        LmCuda(robot, OPTIONS, mapping="lane").solve(poses[:4], home=True),
        refine(robot, poses[:4], home(robot, 4), OPTIONS),
    )
    check_solved(robot, ours, poses)


def test_blocks_solve_every_pose(robot: Robot) -> None:
    poses = reachable(robot, 4)
    library = build_seed_library(robot, 300, 6, seed=3)
    for settings in (None, library):
        check_solved(
            robot,
            LmCuda(robot, OPTIONS, settings, mapping="block", lanes=LANES).solve(poses),
            poses,
        )


def test_what_lanes_leave_is_solved_by_blocks(
    robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lm_cuda, "MAX_BLOCK_POSES", 0)
    poses = reachable(robot, 12)
    library = build_seed_library(robot, 3, 3, seed=3)
    options = OPTIONS._replace(patience=2)
    ours = LmCuda(robot, options, library, lanes=LANES, near=1).solve(poses)
    check_solved(robot, ours, poses)
    assert ours.starts.max() > 1 and (ours.starts == 1).any()


@pytest.mark.slow
@pytest.mark.parametrize("mapping", ["lane", "block"])
def test_64_poses_of_each_robot(robot: Robot, mapping: str) -> None:
    poses = reachable(robot, 64)
    ours = LmCuda(robot, OPTIONS, mapping=mapping, lanes=LANES).solve(poses, home=True)
    check_solved(robot, ours, poses)
    if mapping == "lane":
        check_same(ours, refine(robot, poses, home(robot, 64), OPTIONS))


def test_sliding_and_coupled_joints_are_known() -> None:
    robot = load_robot(urdf=MIXED, base="bench", tip="tool")
    joints = robot.sample(6, seed=1, collision_free=False)
    near = np.clip(joints + 0.02, robot.lower, robot.upper)[:, None]
    poses = robot.forward_kinematics(joints)
    ours = LmCuda(robot, OPTIONS, mapping="lane").solve(poses, near)
    check_same(ours, refine(robot, poses, near, OPTIONS))
    assert (ours.starts == 1).all()
    assert LmCuda(robot, OPTIONS, mapping="block", lanes=2).solve(poses, near).found.all()


@pytest.mark.parametrize("limits", [{"iterations": 0}, {"iterations": 30}, {"starts": 3}])
def test_budgets_end_where_those_of_the_cpu_end(panda: Robot, limits: dict[str, int]) -> None:
    options = OPTIONS._replace(**limits)
    poses = reachable(panda, 9)
    poses[::3, 0] += 3.0
    ours = LmCuda(panda, options, mapping="lane").solve(poses, home=True)
    check_same(ours, refine(panda, poses, home(panda, 9), options))
    blocks = LmCuda(panda, options, mapping="block", lanes=LANES).solve(poses, home=True)
    assert set(blocks.status) <= {FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS}
    assert (blocks.status[::3] != FOUND).all()
    assert blocks.iterations.max() <= options.iterations
    if "starts" in limits:
        assert (blocks.status[::3] == OUT_OF_STARTS).all()


def test_a_pose_out_of_reach_keeps_the_best_joints(panda: Robot, library: SeedLibrary) -> None:
    poses = reachable(panda, 2)
    poses[:, 0] += 5.0
    options = OPTIONS._replace(iterations=80)
    for mapping in ("lane", "block"):
        ours = LmCuda(panda, options, library, mapping=mapping, lanes=LANES).solve(poses)
        assert (ours.status == OUT_OF_ITERATIONS).all()
        reached = panda.forward_kinematics(ours.joints)[:, 0]
        assert (reached > 0.5).all()  # stretched towards it


def test_a_row_does_not_depend_on_its_batch(panda: Robot, library: SeedLibrary) -> None:
    poses = reachable(panda, 6)
    for mapping in ("lane", "block"):
        solver = LmCuda(panda, OPTIONS, library, mapping=mapping, lanes=LANES)
        whole, part = solver.solve(poses), solver.solve(poses[[4, 1]])
        assert np.array_equal(part.joints, whole.joints[[4, 1]])
        assert np.array_equal(part.iterations, whole.iterations[[4, 1]])


def test_the_nearest_remembered_configurations_come_next(
    panda: Robot, library: SeedLibrary
) -> None:
    """A pose that is remembered has its own configuration as the nearest."""
    poses = panda.forward_kinematics(library.joints[[7, 250]])
    for mapping in ("lane", "block"):
        ours = LmCuda(panda, OPTIONS, library, mapping=mapping, lanes=LANES).solve(poses)
        np.testing.assert_allclose(ours.joints, library.joints[[7, 250]])
        assert (ours.iterations == 0).all()


def test_arrays_on_the_device_are_taken_as_they_are(panda: Robot) -> None:
    poses, seeds = reachable(panda, 3), panda.sample(6, seed=6, collision_free=False)
    seeds = seeds.reshape(3, 2, panda.dof)
    solver = LmCuda(panda, OPTIONS, mapping="lane")
    plain = solver.solve(poses, seeds)
    there = solver.solve_on_device(cuda.to_device(poses), cuda.to_device(seeds))
    assert np.array_equal(np.array(there.joints.copy_to_host()), plain.joints)
    check_same(plain, refine(panda, poses, seeds, OPTIONS))


def test_no_poses_give_no_rows(panda: Robot) -> None:
    ours = LmCuda(panda, OPTIONS).solve(np.empty((0, 7)))
    assert ours.joints.shape == (0, panda.dof) and len(ours.solution()) == 0


def test_what_cannot_be_is_refused(panda: Robot) -> None:
    with pytest.raises(SettingError, match="expected a mapping of"):
        LmCuda(panda, OPTIONS, mapping="warp")
    with pytest.raises(SettingError, match="lanes a pose, got 0"):
        LmCuda(panda, OPTIONS, lanes=0)
    with pytest.raises(SettingError, match="iterations only"):
        LmCuda(panda, OPTIONS._replace(time_ns=1000))


@pytest.mark.parametrize("name", ["panda", "nico"])
def test_refined_descends_from_the_networks_hypotheses(name: str) -> None:
    robot = load_robot(name)
    cpu = load_solver("cycleik_refined", robot)
    assert isinstance(cpu, RefinedSolver)
    options = cpu.kernel.options(None)
    poses = robot.forward_kinematics(robot.sample(6, seed=5, collision_free=True))
    theirs, hypotheses = cpu.solve(poses), cpu.proposer.hypotheses(poses).joints
    lanes = RefinedCuda(robot, cpu.proposer.network, options, cpu.library, mapping="lane")
    check_solved(robot, ours := lanes.solve(poses), poses)
    seeds, tried = lanes._hypotheses(cuda.to_device(poses))
    assert tried == 1
    np.testing.assert_allclose(np.array(seeds.copy_to_host()), hypotheses, atol=1e-5)
    first = ours.starts == 1
    assert first.any()
    assert np.array_equal(ours.iterations[first], theirs.iterations[first])
    np.testing.assert_allclose(ours.joints[first], theirs.joints[first], atol=1e-6)
    network = cpu.proposer.network
    blocks = RefinedCuda(robot, network, options, cpu.library, mapping="block", lanes=LANES)
    check_solved(robot, blocks.solve(poses), poses)


@pytest.mark.slow
def test_the_benchmark_writes_its_rows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from benchmarks.accelerator_solvers import __main__ as command
    from benchmarks.accelerator_solvers import measure, solvers

    monkeypatch.setattr(measure, "MEASURED_S", 0.0)
    for module in (command, measure):
        monkeypatch.setattr(module, "TOLERANCES", ((1e-4, 1e-4),))
    monkeypatch.setattr(solvers, "BLOCKS", (LANES,))
    monkeypatch.setattr(lm_cuda, "MAX_BLOCK_POSES", 1)
    masks, out = tmp_path / "masks.npz", tmp_path / "rows.csv"
    command.prepare(masks, ["panda"], 2)
    command.run(out, ["panda"], [1, 2], 600.0, masks, [4], 2)
    with out.open() as file:
        table = list(csv.DictReader(file))
    assert {"lm_cuda", "cycleik_refined_cuda", "lm"} <= {row["solver"] for row in table}
    assert {row["protocol"] for row in table} == {"batch", "candidates"}
    assert all(float(row["within_tolerance"]) == 100 for row in table)
    assert all(row["collision_free"] != "False" and row["note"][:5] != "Error" for row in table)
    command.run(out, ["panda"], [1], 0.0, masks)
    assert len(out.read_text().splitlines()) == 1  # no row begins after the budget
