"""Networks: parameter counts of Table I, limits kept, normalisation."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.learning.factory import build_network
from pipeline.learning.networks import parameter_count
from robots import available_robots, load_robot

TABLE_ONE = {
    "nicol": 29_146_188,
    "nico": 11_514_096,
    "valkyrie": 8_578_060,
    "panda": 17_766_967,
    "fetch": 23_133_958,
}


@pytest.mark.parametrize("name", [name for name in TABLE_ONE if name in available_robots()])
def test_networks_of_table_one_have_the_published_size(name: str) -> None:
    config = compose([f"robot={name}", "model=paper"])
    network = build_network(load_robot(name), config.model)
    assert parameter_count(network) == TABLE_ONE[name]


@pytest.mark.parametrize("model", ["tiny", "compact"])
def test_joints_keep_their_limits_for_any_pose(model: str) -> None:
    robot = load_robot("nico")
    network = build_network(robot, compose([f"model={model}"]).model)
    poses = torch.randn(64, 7) * 10
    joints = network(poses).detach().numpy()
    assert joints.shape == (64, network.heads, robot.dof)
    assert (joints >= robot.lower - 1e-6).all()
    assert (joints <= robot.upper + 1e-6).all()


def test_the_input_is_scaled_to_the_workspace_and_the_output_to_the_limits() -> None:
    robot = load_robot("panda")
    network = build_network(robot, compose(["model=tiny"]).model)
    seen = []

    def record(position: torch.Tensor, quaternion: torch.Tensor) -> torch.Tensor:
        seen.append(position)
        return torch.ones(len(position), robot.dof)

    network.normalised = record  # type: ignore[method-assign]
    corners = torch.as_tensor(robot.workspace, dtype=torch.float32)
    poses = torch.cat((corners, torch.tensor([[1.0, 0, 0, 0]] * 2)), dim=1)
    joints = network(poses)
    torch.testing.assert_close(seen[0], torch.tensor([[-1.0] * 3, [1.0] * 3]))
    np.testing.assert_allclose(joints[0, 0].numpy(), robot.upper, atol=1e-6)
