"""Forward kinematics of every robot against poses computed apart from this project.

tests/data/fk_reference holds 100 configurations a robot with the tip pose of the published URDF
(Pinocchio, checked there against yourdfpy, PyBullet and an independent NumPy chain).
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from pipeline.learning.kinematics import make_kinematics
from pipeline.learning.rotation import quaternion_from_matrix
from robots import available_robots, load_robot, rotations

REFERENCES = Path(__file__).parents[1] / "data" / "fk_reference"
KINEMATICS = ("pytorch_kinematics", "compiled", "products")
CPU = torch.device("cpu")
ROBOTS = [name for name in available_robots() if (REFERENCES / f"{name}.csv").exists()]


def reference(name: str) -> tuple[np.ndarray, np.ndarray]:
    table = pd.read_csv(REFERENCES / f"{name}.csv").to_numpy(dtype=np.float64)
    return table[:, :-7], table[:, -7:]


@pytest.mark.parametrize("name", ROBOTS)
def test_numpy_kinematics_equal_the_reference(name: str) -> None:
    joints, poses = reference(name)
    reached = load_robot(name).forward_kinematics(joints)
    assert np.abs(reached[:, :3] - poses[:, :3]).max() < 1e-9
    assert rotations.rotation_angle(reached[:, 3:], poses[:, 3:]).max() < 1e-9


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("kind", KINEMATICS)
def test_torch_kinematics_equal_the_reference(name: str, kind: str) -> None:
    joints, poses = reference(name)
    kinematics = make_kinematics(load_robot(name), kind, CPU)
    position, rotation = kinematics(torch.as_tensor(joints, dtype=torch.float32))
    quaternion = quaternion_from_matrix(rotation).numpy()
    assert np.abs(position.numpy() - poses[:, :3]).max() < 1e-5
    assert rotations.rotation_angle(quaternion, poses[:, 3:]).max() < 1e-5


@pytest.mark.parametrize("name", ROBOTS)
def test_gradients_equal_those_of_the_library(name: str) -> None:
    robot = load_robot(name)
    values = torch.as_tensor(robot.sample(50, collision_free=False), dtype=torch.float32)
    weights = torch.randn(50, 12, generator=torch.Generator().manual_seed(0))
    gradients = []
    for kind in KINEMATICS:
        joints = values.clone().requires_grad_()
        position, rotation = make_kinematics(robot, kind, CPU)(joints)
        (torch.cat((position, rotation.flatten(1)), dim=1) * weights).sum().backward()
        gradients.append(joints.grad)
    for gradient in gradients[1:]:
        torch.testing.assert_close(gradient, gradients[0], atol=2e-5, rtol=1e-4)
