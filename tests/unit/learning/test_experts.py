"""Experts: nearest cells, a grid that changes nothing, a kernel that answers as torch does."""

from __future__ import annotations

import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from pipeline.learning.cycleik.config import CycleIkModel
from pipeline.learning.cycleik.experts import Experts
from pipeline.learning.cycleik.compiled.answers import (
    answer_rows,
    answer_rows_parallel,
    compiled_experts,
)
from pipeline.learning.networks import matrix_pose
from robots import Robot, load_robot

# Neither a multiple of four rows nor of eight neurons, so that all padding is met.
MODEL = CycleIkModel(
    name="small", kind="experts", hidden=[20, 12], tanh_layers=1, width=1, heads=3, experts=5
)
WEIGHTS = np.array([100.0, 3.0])


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
    robot: Robot, network: Experts, poses: NDArray[np.float64], parallel: bool = False
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    joints = np.full((len(poses), MODEL.heads, robot.dof), np.nan)
    errors = np.full((len(poses), MODEL.heads, 2), np.nan)
    kernel = answer_rows_parallel if parallel else answer_rows
    kernel(robot.chain, compiled_experts(network), poses, WEIGHTS, joints, errors)
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


def test_the_kernel_answers_as_torch_and_ranks_by_error(
    robot: Robot, network: Experts, poses: NDArray[np.float64]
) -> None:
    joints, errors = answers(robot, network, poses)
    wanted = network(as_tensor(poses)).double().numpy().clip(robot.lower, robot.upper)
    for row in range(len(poses)):
        # Each hypothesis of torch is among the kernel's, whose tanh is exact to 1e-4.
        gaps = np.abs(wanted[row][:, None] - joints[row][None]).max(axis=2)
        assert gaps.min(axis=1).max() < 1e-3
        assert sorted(gaps.argmin(axis=1).tolist()) == [0, 1, 2]
    reached = robot.forward_kinematics(joints.reshape(-1, robot.dof)).reshape(*joints.shape[:2], 7)
    distance = np.linalg.norm(reached[..., :3] - poses[:, None, :3], axis=2)
    np.testing.assert_allclose(errors[..., 0], distance, atol=1e-12)
    dots = np.abs((reached[..., 3:] * poses[:, None, 3:]).sum(axis=2)).clip(max=1.0)
    np.testing.assert_allclose(errors[..., 1], 2 * np.arccos(dots), atol=1e-7)
    cost = errors @ WEIGHTS
    assert np.all(np.diff(cost, axis=1) >= 0)


def test_an_answer_does_not_depend_on_batch_or_threads(
    robot: Robot, network: Experts, poses: NDArray[np.float64]
) -> None:
    joints, errors = answers(robot, network, poses)
    for rows in (slice(0, 1), slice(7, 9), slice(100, 333)):
        part, part_errors = answers(robot, network, poses[rows])
        assert np.array_equal(part, joints[rows])
        assert np.array_equal(part_errors, errors[rows])
    both, both_errors = answers(robot, network, poses, parallel=True)
    assert np.array_equal(both, joints)
    assert np.array_equal(both_errors, errors)


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
