"""The refinement in torch against the compiled kernel: the same rows, one way or the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

import baselines
from baselines import SettingError
from baselines.clock import pose_key, uniform
from baselines.descent_torch import damped_solve
from baselines.linearise_torch import TorchChain, rotation_vector, target_frames
from baselines.lm_kernel import FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS, OUT_OF_TIME, LmOptions
from baselines.random_torch import pose_keys, uniforms
from baselines.refine import refine
from baselines.refine_torch import refine_place, refine_torch
from baselines.seed_library import build_seed_library
from robots import Robot, available_robots, load_robot
from robots.kinematics import poses_and_jacobians
from robots.rotations import matrix_from_quaternion

MIXED = Path(__file__).parents[2] / "fixtures" / "mixed.urdf"
CPU = torch.device("cpu")


def robot_of(name: str) -> Robot:
    if name == "mixed":
        return load_robot(urdf=MIXED, base="bench", tip="tool")
    return load_robot(name)


@pytest.fixture(scope="module", params=["panda", "nico"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


@pytest.fixture(scope="module")
def options() -> LmOptions:
    return baselines.load("lm", load_robot("panda")).options(None)


def task(robot: Robot, count: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Poses (N, 7), and two seeds (N, 2, dof) of which the first is home."""
    poses = robot.forward_kinematics(robot.sample(count, seed=5, collision_free=False))
    second = robot.sample(count, seed=6, collision_free=False)
    return poses, np.stack((np.broadcast_to(robot.home, second.shape), second), axis=1)


@pytest.mark.parametrize("name", [*available_robots(), "mixed"])
def test_frames_and_jacobians_equal_the_compiled_ones(name: str) -> None:
    robot = robot_of(name)
    joints = robot.sample(200, seed=2, collision_free=False)
    poses, jacobians = poses_and_jacobians(robot.chain, joints)
    chain = TorchChain(robot.chain, torch.float64, CPU)
    at = chain.frames(torch.as_tensor(joints.T))
    rotation = at.rotation.permute(2, 1, 0).numpy()
    assert np.abs(at.position.T.numpy() - poses[:, :3]).max() < 1e-12
    assert np.abs(rotation - matrix_from_quaternion(poses[:, 3:])).max() < 1e-12
    assert np.abs(chain.jacobian(at).permute(2, 1, 0).numpy() - jacobians).max() < 1e-12


def test_the_error_is_the_rotation_vector_half_turns_included() -> None:
    angles = np.array([0.0, 1e-12, 1e-3, 2.0, np.pi - 1e-3])
    axis = np.array([0.6, 0.0, 0.8])
    turns = np.concatenate((np.cos(angles / 2)[:, None], np.sin(angles / 2)[:, None] * axis), 1)
    half = np.concatenate((np.zeros((3, 1)), np.eye(3)), axis=1)
    poses = np.concatenate((np.zeros((8, 3)), np.concatenate((turns, half))), axis=1)
    goal, _ = target_frames(torch.as_tensor(poses))
    here = torch.eye(3, dtype=torch.float64)[..., None].expand(3, 3, 8)
    vector, angle = rotation_vector(here, goal)
    np.testing.assert_allclose(angle, [*angles, *[np.pi] * 3], atol=1e-9)
    np.testing.assert_allclose(vector.T[:5], angles[:, None] * axis, atol=1e-9)
    np.testing.assert_allclose(torch.linalg.vector_norm(vector, dim=0)[5:], np.pi)


def test_the_damped_systems_are_solved() -> None:
    generator = torch.Generator().manual_seed(0)
    J = torch.randn(7, 6, 50, generator=generator, dtype=torch.float64)
    error = torch.randn(6, 50, generator=generator, dtype=torch.float64)
    movable = J * (torch.rand(7, 1, 50, generator=generator) < 0.8)
    damping = torch.full((50,), 1e-3, dtype=torch.float64)
    y = damped_solve(movable, J, error, damping)
    normal = torch.einsum("kin,kjn->nij", movable, movable)
    normal += 1e-3 * torch.eye(6, dtype=torch.float64)
    torch.testing.assert_close(torch.einsum("nij,jn->in", normal, y), error, atol=1e-9, rtol=0)


def test_random_numbers_are_those_of_the_kernel_bit_for_bit() -> None:
    poses, _ = task(load_robot("panda"), 20)
    keys = pose_keys(torch.as_tensor(poses))
    expected = [pose_key(pose) for pose in poses]
    assert [int(key) % 2**64 for key in keys] == [int(key) for key in expected]
    assert torch.equal(keys, pose_keys(torch.as_tensor(poses * [1, 1, 1, -1, -1, -1, -1])))
    ours = uniforms(keys[:, None], torch.arange(50)).numpy()
    theirs = [[uniform(np.uint64(key), i) for i in range(50)] for key in expected]
    assert np.array_equal(ours, np.array(theirs))


@pytest.mark.parametrize("seeds", [0, 1, 2])
def test_rows_are_those_of_the_kernel(robot: Robot, options: LmOptions, seeds: int) -> None:
    poses, given = task(robot)
    kernel = refine(robot, poses, given[:, :seeds], options)
    ours = refine_torch(refine_place(robot, "cpu", "float64"), poses, given[:, :seeds], options)
    assert ours.found.all() and kernel.found.all()
    assert (ours.starts == kernel.starts).mean() > 0.99
    assert (ours.iterations == kernel.iterations).mean() > 0.99
    assert (np.abs(ours.joints - kernel.joints).max(axis=1) < 1e-6).mean() > 0.99
    assert ours.solution().reason == kernel.solution().reason
    assert (ours.time_s > 0).all()


@pytest.mark.parametrize("seeds", [0, 2])
def test_a_memory_is_asked_as_the_kernel_asks(robot: Robot, options: LmOptions, seeds: int) -> None:
    poses, given = task(robot)
    library = build_seed_library(robot, 1000, 4, seed=3)
    kernel = refine(robot, poses, given[:, :seeds], options, library=library)
    place = refine_place(robot, "cpu", "float64")
    ours = refine_torch(place, poses, given[:, :seeds], options, library)
    assert ours.found.all()
    assert (ours.starts == kernel.starts).mean() > 0.99
    assert (ours.iterations == kernel.iterations).mean() > 0.98
    plain = refine(robot, poses, given[:, :seeds], options)
    assert kernel.iterations.mean() != plain.iterations.mean()


@pytest.mark.parametrize("limits", [{"iterations": 0}, {"iterations": 30}, {"starts": 3}])
def test_budgets_end_where_those_of_the_kernel_end(robot: Robot, limits: dict[str, int]) -> None:
    """Out of reach, and shallow budgets: starts side by side must not reach beyond them."""
    # No proof is asked for that a pose is out of reach: the twin has none.
    options = baselines.load("lm", robot).options(None)._replace(nearest_starts=0, **limits)
    poses, seeds = task(robot, 150)
    poses[::3, 0] += 3.0
    kernel = refine(robot, poses, seeds, options)
    ours = refine_torch(refine_place(robot, "cpu", "float64"), poses, seeds, options)
    same = ours.status == kernel.status
    assert same.mean() > 0.98
    assert set(ours.status) <= {FOUND, OUT_OF_ITERATIONS, OUT_OF_STARTS}
    assert (ours.iterations == kernel.iterations).mean() > 0.98
    assert (ours.starts == kernel.starts).mean() > 0.98
    assert ours.iterations.max() <= options.iterations
    assert (np.abs(ours.joints - kernel.joints).max(axis=1) < 1e-6).mean() > 0.95


@pytest.mark.parametrize("name", [*available_robots()])
def test_every_pose_is_solved_inside_the_limits(name: str, options: LmOptions) -> None:
    robot = load_robot(name)
    poses, seeds = task(robot, 200)
    for precision in ("float64", "mixed"):
        refined = refine_torch(refine_place(robot, "cpu", precision), poses, seeds, options)
        assert refined.found.all()
        reached = robot.forward_kinematics(refined.joints)
        assert np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).max() <= 1.0001e-4
        assert (refined.joints >= robot.lower).all() and (refined.joints <= robot.upper).all()


def test_sliding_and_coupled_joints_are_known(options: LmOptions) -> None:
    robot = robot_of("mixed")
    joints = robot.sample(20, seed=1, collision_free=False)
    near = np.clip(joints + 0.02, robot.lower, robot.upper)
    place = refine_place(robot, "cpu", "float64")
    refined = refine_torch(place, robot.forward_kinematics(joints), near[:, None], options)
    assert refined.found.all()
    assert (refined.starts == 1).all()


def test_a_row_does_not_depend_on_its_batch(robot: Robot, options: LmOptions) -> None:
    poses, seeds = task(robot)
    place = refine_place(robot, "cpu", "float64")
    whole = refine_torch(place, poses, seeds[:, :1], options)
    hard = np.argsort(whole.starts)[-3:]
    for rows in (hard[-1:], hard, np.arange(37)):
        part = refine_torch(place, poses[rows], seeds[rows, :1], options)
        assert np.array_equal(part.starts, whole.starts[rows])
        np.testing.assert_allclose(part.joints, whole.joints[rows], atol=1e-12)


def test_seeds_outside_the_limits_and_tensors_are_taken(robot: Robot, options: LmOptions) -> None:
    poses, seeds = task(robot, 50)
    far = torch.as_tensor(seeds * 100)
    place = refine_place(robot, "cpu", "float64")
    ours = refine_torch(place, torch.as_tensor(poses), far, options)
    kernel = refine(robot, poses, far.numpy(), options)
    assert np.array_equal(ours.starts, kernel.starts)


def test_the_clock_ends_what_cannot_be_reached(robot: Robot, options: LmOptions) -> None:
    poses, seeds = task(robot, 4)
    poses[:, 0] += 5.0
    place = refine_place(robot, "cpu", "float64")
    refined = refine_torch(place, poses, seeds, options._replace(time_ns=1_000_000))
    assert (refined.status == OUT_OF_TIME).all()


def test_no_poses_give_no_rows(robot: Robot, options: LmOptions) -> None:
    place = refine_place(robot, "cpu", "float64")
    refined = refine_torch(place, np.empty((0, 7)), np.empty((0, 2, robot.dof)), options)
    assert refined.joints.shape == (0, robot.dof)
    assert len(refined.solution()) == 0


def test_what_cannot_be_is_refused(robot: Robot, options: LmOptions) -> None:
    for device, precision in (("gpu", "float64"), ("cpu", "float16")):
        with pytest.raises(SettingError, match="expected a device of"):
            refine_place(robot, device, precision)
    if not torch.cuda.is_available():
        with pytest.raises(SettingError, match="torch sees none"):
            refine_place(robot, "cuda", "float64")
    fine = options._replace(position_tolerance_m=1e-7)
    poses, seeds = task(robot, 2)
    with pytest.raises(SettingError, match="use float64"):
        refine_torch(refine_place(robot, "cpu", "mixed"), poses, seeds, fine)


@pytest.mark.gpu
@pytest.mark.parametrize("precision", ["float64", "mixed"])
def test_an_accelerator_solves_what_the_kernel_solves(
    robot: Robot, options: LmOptions, precision: str
) -> None:
    poses, seeds = task(robot, 2000)
    kernel = refine(robot, poses, seeds, options)
    place = refine_place(robot, "cuda", precision)
    first, again = (refine_torch(place, poses, seeds, options) for _ in range(2))
    assert first.found.all()
    assert np.array_equal(first.joints, again.joints)
    assert (first.starts == kernel.starts).mean() > 0.98
