"""The adversarial network: an ensemble, two players with a loss each, and their training."""

from __future__ import annotations

import pytest
import torch

from pipeline.learning.factory import build_network, make_objective, model_config
from pipeline.learning.gan.network import Gan
from pipeline.learning.gan.objective import GanObjective
from robots import Robot, load_robot
from tests.samplers import SMALL, check_training, pose_set, train_config

SIZES = {"generators": 3, "noise": 4, "discriminator": [16]}
VALUES = {**SMALL, **SIZES, "kind": "gan", "adversarial_weight": 0.1, "limit_weight": 1.0}


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture
def objective(panda: Robot) -> GanObjective:
    torch.manual_seed(0)
    network = build_network(panda, model_config(VALUES))
    made = make_objective(panda, network, train_config(), torch.device("cpu"), seed=3)
    assert isinstance(made, GanObjective) and isinstance(made.network, Gan)
    return made


def gradients(objective: GanObjective, loss: torch.Tensor) -> dict[str, torch.Tensor]:
    objective.network.zero_grad()
    loss.backward()
    return {
        name: torch.zeros_like(p) if p.grad is None else p.grad.clone()
        for name, p in objective.network.named_parameters()
    }


def test_each_player_descends_on_its_own_loss(panda: Robot, objective: GanObjective) -> None:
    """The gradient of the sum is that of each term by itself, for the player it is for."""
    network, (poses, joints) = objective.network, pose_set(panda, 16)

    def unit() -> torch.Tensor:
        return network.generated(poses, objective.latents(poses, 1, 7)).squeeze(1)

    both = gradients(objective, objective.loss(poses, joints, 7, 0.0))
    generators = gradients(objective, objective.generator_loss(poses, unit()))
    real = network.unit(joints)
    judge = gradients(objective, objective.discriminator_loss(poses, real, unit()))
    for name, gradient in both.items():
        own, other = (judge, generators) if "discriminator" in name else (generators, judge)
        assert not other[name].any()
        torch.testing.assert_close(gradient, own[name])
    assert any(g.any() for g in judge.values()) and any(g.any() for g in generators.values())


def test_a_draw_picks_one_generator_of_the_ensemble(panda: Robot, objective: GanObjective) -> None:
    network, (poses, _) = objective.network, pose_set(panda, 2)
    latents = network.latents(1, 3, seed=0)
    latents[..., -1] = torch.tensor([0.1, 0.5, 0.9])
    drawn = network.generated(poses, latents)
    described = network.described(poses)
    for index, generator in enumerate(network.generators):
        noise = latents[0, index, :-1].expand(2, -1)
        expected = generator(torch.cat((described, noise), dim=1))
        torch.testing.assert_close(drawn[:, index], expected)


def test_losses_by_hand(panda: Robot, objective: GanObjective) -> None:
    """Joints of the set reach their poses; a joint one half beyond a limit costs 0.25 / dof."""
    network, (poses, joints) = objective.network, pose_set(panda, 8)
    network.adversarial_weight = 0.0
    unit = network.unit(joints)
    assert float(objective.generator_loss(poses, unit).detach()) == pytest.approx(0, abs=1e-4)
    network.limit_weight = 1.0
    beyond = torch.zeros_like(unit)
    beyond[:, 0] = 1.5
    reached = torch.tensor(
        panda.forward_kinematics((network.joint_centre + network.joint_scale * beyond).numpy()),
        dtype=torch.float32,
    )
    cost = float(objective.generator_loss(reached, beyond).detach())
    assert cost == pytest.approx(0.25 / panda.dof, abs=1e-4)
    with torch.no_grad():
        for parameter in network.discriminator.parameters():
            parameter.zero_()
    undecided = float(objective.discriminator_loss(poses, unit, unit).detach())
    assert undecided == pytest.approx(2 * 0.6931, abs=1e-3)


def test_training_brings_draws_nearer(panda: Robot, objective: GanObjective) -> None:
    data = pose_set(panda, 128)
    before = float(objective.errors(data[0])[0].mean())
    check_training(objective, objective.network, data, steps=60)
    assert float(objective.errors(data[0])[0].mean()) < 0.8 * before
