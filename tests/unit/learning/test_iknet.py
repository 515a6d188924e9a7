"""IKNet: a density of joint after joint, draws that belong to it, and its training."""

from __future__ import annotations

import numpy as np
import pytest
import torch

from pipeline.learning.factory import build_network, make_objective, model_config
from pipeline.learning.iknet.network import LEAST_SCALE, IkNet
from robots import Robot, load_robot
from tests.samplers import SMALL, check_training, pose_set, train_config

VALUES = {**SMALL, "kind": "iknet", "embedding": 16, "components": 3, "forward_weight": 0.0}


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


def made(robot: Robot, **changed: float) -> IkNet:
    torch.manual_seed(0)
    network = build_network(robot, model_config({**VALUES, **changed}))
    assert isinstance(network, IkNet)
    return network


def test_a_joint_depends_on_those_before_it_alone(panda: Robot) -> None:
    network, (poses, joints) = made(panda), pose_set(panda, 4)
    before = network.log_likelihood(poses, joints)
    joints[:, 3] += 0.3
    changed = network.log_likelihood(poses, joints) != before
    assert not changed[:, :3].any()
    assert changed[:, 3:].all()


@torch.no_grad()
def test_the_density_of_each_joint_integrates_to_one_and_its_moments_are_those_of_draws(
    panda: Robot,
) -> None:
    """The first joint by quadrature over all angles, against 20,000 draws inside the limits."""
    network, (poses, joints) = made(panda), pose_set(panda, 1)
    unit = torch.linspace(-8, 8, 16001)
    rows = joints.repeat(len(unit), 1)
    rows[:, 0] = network.joint_centre[0] + network.joint_scale[0] * unit
    density = network.log_likelihood(poses.expand(len(unit), -1), rows)[:, 0].exp()
    step = float(unit[1] - unit[0])
    assert float(density.sum()) * step == pytest.approx(1, abs=1e-3)
    drawn = network.unit(network.draws(poses, network.latents(1, 20000, seed=1)))[0, :, 0]
    clamped = unit.clamp(-1, 1)
    mean = float((density * clamped).sum()) * step
    square = float((density * clamped**2).sum()) * step
    assert float(drawn.mean()) == pytest.approx(mean, abs=0.02)
    assert float((drawn**2).mean()) == pytest.approx(square, abs=0.02)


def test_the_pose_makes_the_weights_and_the_scale_has_a_floor(panda: Robot) -> None:
    network, (poses, joints) = made(panda), pose_set(panda, 2)
    first, second = network.primary(poses)
    assert first.shape == (2, 7, SMALL["width"], 8)
    assert not torch.allclose(first[0], first[1])
    with torch.no_grad():
        network.second.bias.fill_(-1e3)
    assert torch.isfinite(network.log_likelihood(poses, joints)).all()
    highest = -np.log(LEAST_SCALE) - 0.5 * np.log(2 * np.pi)
    assert float(network.log_likelihood(poses, joints).max()) <= highest + 1e-4
    assert second.shape == (2, 7, 9, SMALL["width"] + 1)


@pytest.mark.parametrize("weight", [0.0, 1.0])
def test_the_loss_falls_with_and_without_forward_kinematics(panda: Robot, weight: float) -> None:
    network = made(panda, forward_weight=weight)
    objective = make_objective(panda, network, train_config(), torch.device("cpu"), seed=3)
    first, last = check_training(objective, network, pose_set(panda, 128), steps=40)
    assert last < first - 0.3
