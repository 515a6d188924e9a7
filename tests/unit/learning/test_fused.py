"""The closed form against autograd through the chain, in float64, for every loss and robot."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.learning.fused import FusedCycleLoss
from pipeline.learning.kinematics import ChainKinematics
from pipeline.learning.losses import PoseLoss
from robots import available_robots, load_robot

CPU = torch.device("cpu")


@pytest.mark.parametrize("loss", ["smooth", "former", "matrix"])
@pytest.mark.parametrize("name", available_robots())
def test_loss_and_gradient_are_autograds(name, loss):
    robot = load_robot(name)
    train = replace(compose([f"robot={name}", "profile=paper"]).train, loss=loss)
    generator = np.random.default_rng(3)
    joints = generator.uniform(robot.lower, robot.upper, (200, robot.dof))
    # Far answers and near ones: within the quadratic part of the losses too.
    spread = np.where(np.arange(200) % 2, 1e-3, 1.0)[:, None]
    wanted = np.clip(
        joints + spread * generator.normal(size=joints.shape), robot.lower, robot.upper
    )
    poses = torch.as_tensor(robot.forward_kinematics(wanted))

    reference = torch.tensor(joints, requires_grad=True)
    kinematics = ChainKinematics(robot.chain, CPU, torch.float64)
    expected = PoseLoss(train)(*kinematics(reference), poses)
    expected.sum().backward()

    fused = FusedCycleLoss(robot.chain, train, CPU, torch.float64)
    losses, gradient = fused.rows(torch.tensor(joints), poses)
    assert torch.allclose(losses, expected.detach(), rtol=1e-9, atol=1e-12)
    assert torch.allclose(gradient, reference.grad, rtol=1e-7, atol=1e-9)

    through = torch.tensor(joints, requires_grad=True)
    (3.0 * fused(through, poses)).backward()
    assert torch.allclose(through.grad, 3.0 * reference.grad / len(joints), rtol=1e-7, atol=1e-9)


def test_frames_are_the_kinematics_of_the_robot():
    robot = load_robot("fetch")  # with a sliding joint
    joints = robot.sample(50, seed=1, collision_free=False)
    train = compose(["robot=fetch"]).train
    _, tip = FusedCycleLoss(robot.chain, train, CPU, torch.float64).frames(torch.tensor(joints))
    assert np.allclose(tip[:, :3, 3].numpy(), robot.forward_kinematics(joints)[:, :3], atol=1e-12)
