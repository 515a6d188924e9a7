"""Experts: nearest cells, a grid that changes nothing, a kernel that answers as torch does."""

from __future__ import annotations

from copy import deepcopy

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from baselines import SettingError
from baselines.registry import using
from pipeline import load_solver
from pipeline.learning.cycleik.compiled.answers import (
    answer,
    answer_on_threads,
    answer_rows,
    compiled_experts,
    make_work,
)
from pipeline.learning.cycleik.config import CycleIkModel
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.cycleik.solver import CycleIk
from pipeline.learning.networks import matrix_pose
from pipeline.learning.refined import RefinedSolver
from robots import Robot, available_robots, load_robot
from robots.rotations import rotation_angle

# No multiples of the rows of a tile, of a vector of neurons or of the lanes: all padding is met.
MODEL = CycleIkModel(
    name="small", kind="experts", hidden=[20, 12], tanh_layers=1, width=1, heads=3, experts=5
)
WEIGHTS = np.array([100.0, 3.0])
ROUNDING = 2e-3  # of errors so weighted: 1e-5 rad in a few joints of an arm of a metre


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("nico")


@pytest.fixture(scope="module")
def poses(robot: Robot) -> NDArray[np.float64]:
    return robot.forward_kinematics(robot.sample(333, seed=4, collision_free=False))


@pytest.fixture(scope="module")
def network(robot: Robot, poses: NDArray[np.float64]) -> Experts:
    torch.manual_seed(1)
    made = Experts(robot, MODEL)
    made.prepare(as_tensor(poses))
    with torch.no_grad():
        for bias in made.biases:
            bias.normal_(0, 0.5)
        for weight in made.weights:
            weight *= 1.5
    return made.eval().requires_grad_(False)


def as_tensor(poses: NDArray[np.float64]) -> torch.Tensor:
    return torch.as_tensor(poses, dtype=torch.float32)


def answers(
    robot: Robot,
    network: Experts,
    poses: NDArray[np.float64],
    threads: int = 1,
    nearer: int = 0,
    precision: str = "float32",
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    joints = np.full((len(poses), network.heads, robot.dof), np.nan)
    errors = np.full((len(poses), network.heads, 2), np.nan)
    arguments = (
        robot.chain,
        compiled_experts(network, precision),
        poses,
        WEIGHTS,
        nearer,
        joints,
        errors,
    )
    if threads == 1:
        answer_rows(*arguments)
    else:
        answer_on_threads(threads, *arguments)
    return joints, errors


def test_a_pose_goes_to_the_nearest_centre_of_the_metric(
    network: Experts, poses: NDArray[np.float64]
) -> None:
    shown = as_tensor(poses)
    features = matrix_pose(network.scaled(shown), shown[:, 3:])
    distances = torch.cdist(features.double() * network.metric, network.centres.double())
    assert torch.equal(network.cell(features), distances.argmin(1))
    assert len(network.cell(features).unique()) == MODEL.experts


def test_an_answer_is_that_of_its_expert_alone(
    network: Experts, poses: NDArray[np.float64]
) -> None:
    shown = as_tensor(poses[:50])
    features = matrix_pose(network.scaled(shown), shown[:, 3:])
    for row, cell in enumerate(network.cell(features).tolist()):
        values = (features[row] - network.mean[cell]) / network.scale[cell]
        for index, (weight, bias) in enumerate(zip(network.weights, network.biases, strict=True)):
            values = values @ weight[cell] + bias[cell, 0]
            last = index == len(network.weights) - 1
            gelu = torch.nn.functional.gelu(values, approximate="tanh")
            values = torch.tanh(values) if last else gelu
        joints = network.joint_centre + network.joint_scale * values.unflatten(0, (3, -1))
        torch.testing.assert_close(network(shown)[row], joints, rtol=1e-4, atol=1e-5)


def ranked_by_torch(
    robot: Robot, network: Experts, poses: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Hypotheses (N, K, dof) of torch in float64, best first, and their costs (N, K)."""
    with torch.no_grad():
        output = deepcopy(network).double()(torch.as_tensor(poses)).numpy()
    joints = output.clip(robot.lower, robot.upper)
    reached = robot.forward_kinematics(joints.reshape(-1, robot.dof)).reshape(*joints.shape[:2], 7)
    distance = np.linalg.norm(reached[..., :3] - poses[:, None, :3], axis=2)
    goals = np.broadcast_to(poses[:, None, 3:], reached[..., 3:].shape)
    costs = np.stack([distance, rotation_angle(reached[..., 3:], goals)], axis=2) @ WEIGHTS
    order = costs.argsort(axis=1, kind="stable")
    return np.take_along_axis(joints, order[..., None], 1), np.take_along_axis(costs, order, 1)


def check_against_torch(
    robot: Robot, network: Experts, poses: NDArray[np.float64], precision: str
) -> None:
    digits = 1.0 if precision == "float32" else 1e-2
    joints, errors = answers(robot, network, poses, precision=precision)
    wanted, costs = ranked_by_torch(robot, network, poses)
    np.testing.assert_allclose(errors @ WEIGHTS, costs, rtol=0, atol=digits * ROUNDING)
    # The order of heads this close is left to rounding.
    clear = (np.diff(costs, axis=1) > ROUNDING).all(axis=1)
    assert clear.mean() > 0.7
    np.testing.assert_allclose(joints[clear], wanted[clear], rtol=0, atol=1e-5 * digits)


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_the_kernel_answers_as_torch_in_float64(
    robot: Robot, network: Experts, poses: NDArray[np.float64], precision: str
) -> None:
    check_against_torch(robot, network, poses, precision)


@pytest.mark.parametrize("name", available_robots())
def test_the_shipped_networks_answer_as_torch_in_float64(name: str) -> None:
    solver = load_solver("cycleik", load_robot(name))
    assert isinstance(solver, CycleIk)
    assert isinstance(solver.network, Experts)
    robot = solver.robot
    poses = robot.forward_kinematics(robot.sample(500, seed=6, collision_free=False))
    check_against_torch(robot, solver.network, poses, "float64")


def test_the_second_nearest_cell_answers_as_torch_in_float64(
    robot: Robot, network: Experts, poses: NDArray[np.float64]
) -> None:
    def second(features: torch.Tensor) -> torch.Tensor:
        distances = torch.cdist(features.double() * other.metric.double(), other.centres.double())
        return distances.argsort(1)[:, 1]

    other = deepcopy(network)
    other.cell = second  # type: ignore[method-assign]
    joints, errors = answers(robot, network, poses, nearer=1)
    wanted, costs = ranked_by_torch(robot, other, poses)
    np.testing.assert_allclose(errors @ WEIGHTS, costs, rtol=0, atol=ROUNDING)
    assert not np.array_equal(joints, answers(robot, network, poses)[0])
    clear = (np.diff(costs, axis=1) > ROUNDING).all(axis=1)
    np.testing.assert_allclose(joints[clear], wanted[clear], rtol=0, atol=1e-5)


def test_several_cells_give_the_best_of_all_their_hypotheses() -> None:
    robot = load_robot("panda")
    poses = robot.forward_kinematics(robot.sample(200, seed=6, collision_free=False))
    one, two = (load_solver("cycleik", robot, cells=cells) for cells in (1, 2))
    assert isinstance(one, CycleIk)
    assert isinstance(two, CycleIk)
    first, both = one.hypotheses(poses), two.hypotheses(poses)
    cost = both.position_mm / two.position_tolerance_mm
    cost = cost + both.rotation_deg / two.rotation_tolerance_deg
    assert both.joints.shape == (200, 8, 7)
    assert (np.diff(cost, axis=1) >= 0).all()
    of_one = first.position_mm / 10 + first.rotation_deg / 20
    assert (cost[:, 0] <= of_one[:, 0]).all()
    assert (cost[:, 0] < of_one[:, 0]).any()
    # All hypotheses of the nearest cell are among them.
    for row in range(200):
        kept = {tuple(joints) for joints in both.joints[row]}
        assert {tuple(joints) for joints in first.joints[row]} <= kept


@pytest.mark.parametrize("cells", [0, 65, -1])
def test_cells_that_the_network_has_not_are_refused(cells: int) -> None:
    with pytest.raises(SettingError, match=f"expected cells from 1 to 64 .*, got {cells}"):
        load_solver("cycleik", load_robot("panda"), cells=cells)


@pytest.mark.parametrize("name", available_robots())
@pytest.mark.parametrize(("precision", "near"), [("auto", 1e-7), ("float32", 1e-4)])
def test_a_compact_network_computes_in_float64_unless_told(
    name: str, precision: str, near: float
) -> None:
    solver = load_solver("cycleik", load_robot(name), precision=precision)
    assert isinstance(solver, CycleIk)
    assert isinstance(solver.network, Experts)
    robot = solver.robot
    poses = robot.forward_kinematics(robot.sample(2000, seed=7, collision_free=False))
    heads = ranked_by_torch(robot, solver.network, poses)[0]
    away = np.abs(solver.solve(poses).joints[:, None] - heads).max(axis=2).min(axis=1)
    # A pose within rounding of a border between cells may get the neighbour's answer.
    assert np.sort(away)[-2] < near


@pytest.mark.parametrize("name", ["fetch", "nicol"])  # endless joints; a box
@pytest.mark.parametrize("guessed", [False, True])
def test_a_query_answers_as_a_batch_does_bit_by_bit(name: str, guessed: bool) -> None:
    robot = load_robot(name)
    poses = robot.forward_kinematics(robot.sample(200, seed=8, collision_free=False))
    guesses = 2 * robot.sample(200, seed=9) if guessed else None
    solver = load_solver("cycleik", robot)
    whole = solver.solve(poses, initial=guesses)
    assert 0 < whole.found.sum() < len(poses)
    for row in range(len(poses)):
        guess = None if guesses is None else guesses[row]
        joints, found = solver.solve_one(poses[row], guess)
        few = solver.solve(poses[row : row + 1], initial=None if guess is None else guess[None])
        assert np.array_equal(joints, whole.joints[row])
        assert np.array_equal(few.joints[0], whole.joints[row])
        assert found == few.found[0] == whole.found[row]
        assert few.reason[0] == whole.reason[row]


@pytest.mark.parametrize("name", available_robots())
def test_what_is_proven_out_of_reach_is_not_claimed(name: str) -> None:
    robot = load_robot(name)
    solver = load_solver("cycleik", robot, position_tolerance_mm=1e6, rotation_tolerance_deg=180)
    poses = robot.forward_kinematics(robot.sample(20, seed=8, collision_free=False))
    assert solver.solve(poses).found.all()
    poses[::2, :3] += [5.0, 0.0, 0.0]
    whole = solver.solve(poses)
    np.testing.assert_array_equal(whole.found, np.arange(20) % 2 == 1)
    assert set(whole.reason[::2]) == {"proven out of reach"}
    for row, pose in enumerate(poses):
        assert solver.solve_one(pose)[1] == whole.found[row]
        assert solver.solve(pose[None]).reason[0] == whole.reason[row]


def test_a_query_heeds_tolerances_that_change() -> None:
    robot = load_robot("panda")
    solver = load_solver("cycleik", robot)
    assert isinstance(solver, CycleIk)
    pose = robot.forward_kinematics(robot.home)[0]
    assert solver.solve_one(pose)[1]
    solver.position_tolerance_mm = 1e-9
    assert not solver.solve_one(pose)[1]


def test_seeds_of_a_descent_are_computed_in_float32() -> None:
    solver = load_solver("cycleik_refined", load_robot("panda"))
    assert isinstance(solver, RefinedSolver)
    assert isinstance(solver.proposer, CycleIk)
    assert solver.proposer.precision == "float32"


def test_a_precision_that_does_not_exist_is_refused() -> None:
    with pytest.raises(SettingError, match=r"no precision 'half'.*auto, float32, float64"):
        load_solver("cycleik", load_robot("panda"), precision="half")


def test_a_refined_solver_takes_more_cells() -> None:
    robot = load_robot("panda")
    poses = robot.forward_kinematics(robot.sample(20, seed=6, collision_free=False))
    with using({"cycleik": {"cells": 2}}):
        solver = load_solver("cycleik_refined", robot)
    assert solver.solve(poses).found.all()
    assert solver.solve_one(poses[0])[1]


def test_errors_are_those_of_the_joints(
    robot: Robot, network: Experts, poses: NDArray[np.float64]
) -> None:
    joints, errors = answers(robot, network, poses)
    reached = robot.forward_kinematics(joints.reshape(-1, robot.dof)).reshape(*joints.shape[:2], 7)
    distance = np.linalg.norm(reached[..., :3] - poses[:, None, :3], axis=2)
    np.testing.assert_allclose(errors[..., 0], distance, atol=1e-12)
    goals = np.broadcast_to(poses[:, None, 3:], reached[..., 3:].shape)
    angles = rotation_angle(reached[..., 3:], goals)
    np.testing.assert_allclose(errors[..., 1], angles, atol=1e-7)


def test_an_answer_does_not_depend_on_batch_or_threads(
    robot: Robot, network: Experts, poses: NDArray[np.float64]
) -> None:
    joints, errors = answers(robot, network, poses)
    for rows in (slice(0, 1), slice(7, 9), slice(100, 333)):
        part, part_errors = answers(robot, network, poses[rows])
        assert np.array_equal(part, joints[rows])
        assert np.array_equal(part_errors, errors[rows])
    for threads in (2, 3):
        again, again_errors = answers(robot, network, poses, threads)
        assert np.array_equal(again, joints)
        assert np.array_equal(again_errors, errors)


def test_work_may_be_kept_from_call_to_call(
    robot: Robot, network: Experts, poses: NDArray[np.float64]
) -> None:
    joints, errors = answers(robot, network, poses[:20])
    experts = compiled_experts(network, np.float32)
    work = make_work(experts, 1)
    one, measured = np.empty((1, MODEL.heads, robot.dof)), np.empty((1, MODEL.heads, 2))
    for row in range(20):
        answer(robot.chain, experts, poses[row : row + 1], WEIGHTS, 0, one, measured, work)
        assert np.array_equal(one[0], joints[row])
        assert np.array_equal(measured[0], errors[row])


def test_heads_of_equal_error_keep_their_order_and_all_are_answered(
    robot: Robot, poses: NDArray[np.float64]
) -> None:
    made = Experts(robot, MODEL)
    made.prepare(as_tensor(poses))
    with torch.no_grad():
        last, bias = made.weights[-1], made.biases[-1]
        for head in range(1, MODEL.heads):
            columns = slice(head * robot.dof, (head + 1) * robot.dof)
            last[..., columns] = last[..., : robot.dof]
            bias[..., columns] = bias[..., : robot.dof]
    joints, errors = answers(robot, made.eval(), poses)
    assert np.isfinite(joints).all()
    assert np.array_equal(joints[:, 0], joints[:, 2])
    assert np.array_equal(errors[:, 0], errors[:, 2])


def test_gradients_reach_only_the_experts_of_the_batch(
    robot: Robot, poses: NDArray[np.float64]
) -> None:
    made = Experts(robot, MODEL)
    made.prepare(as_tensor(poses))
    shown = as_tensor(poses[:3])
    used = set(made.cell(matrix_pose(made.scaled(shown), shown[:, 3:])).tolist())
    made(shown).square().sum().backward()
    for weight in made.weights:
        assert weight.grad is not None
        norms = weight.grad.flatten(1).norm(dim=1)
        assert {cell for cell in range(MODEL.experts) if norms[cell] > 0} == used
