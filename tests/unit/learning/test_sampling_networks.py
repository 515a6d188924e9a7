"""What every network that draws from latents must do: limits, independence, one pose two signs."""

from __future__ import annotations

import pytest
import torch

from pipeline.learning.factory import build_network
from pipeline.learning.networks import SamplingNetwork
from pipeline.learning.registry import imported, kinds, method_of
from robots import load_robot
from tests.samplers import pose_set
from tests.unit.learning.test_methods import model_of

KINDS = [
    kind
    for kind in kinds()
    if issubclass(imported(method_of(kind).networks[kind]), SamplingNetwork)
]


@pytest.mark.parametrize("name", ["nico", "panda"])
@pytest.mark.parametrize("kind", KINDS)
def test_draws_keep_limits_and_do_not_depend_on_the_poses_beside(kind: str, name: str) -> None:
    robot = load_robot(name)
    torch.manual_seed(0)
    network = build_network(robot, model_of(kind))
    assert isinstance(network, SamplingNetwork)
    poses, _ = pose_set(robot, 5)
    latents = network.latents(1, 40, seed=0)
    with torch.no_grad():
        drawn = network.draws(poses, latents)
        assert drawn.shape == (5, 40, robot.dof)
        assert (drawn >= torch.tensor(robot.lower) - 1e-5).all()
        assert (drawn <= torch.tensor(robot.upper) + 1e-5).all()
        assert (drawn.std(dim=1) > 0).any(dim=1).all(), "other latents, other solutions"
        alone = network.draws(poses[3:4], latents)[0]
        torch.testing.assert_close(alone, drawn[3], atol=1e-4, rtol=1e-4)
        negated = torch.cat((poses[:, :3], -poses[:, 3:]), dim=1)
        torch.testing.assert_close(network.draws(negated, latents), drawn, atol=1e-4, rtol=1e-4)
        assert network(poses).shape == (5, 1, robot.dof)


def test_latents_follow_from_their_seed_and_only_normal_ones_are_scaled() -> None:
    network = build_network(load_robot("nico"), model_of("iknet"))
    assert isinstance(network, SamplingNetwork)
    whole, half = network.latents(3, 50, seed=1), network.latents(3, 50, seed=1, scale=0.5)
    dof = network.dof
    torch.testing.assert_close(half[..., :dof], whole[..., :dof] / 2)
    torch.testing.assert_close(half[..., dof:], whole[..., dof:])
    assert float(whole[..., dof:].min()) >= 0 and float(whole[..., dof:].max()) < 1
    assert not torch.equal(whole, network.latents(3, 50, seed=2))
