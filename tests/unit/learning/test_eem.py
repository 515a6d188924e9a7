"""The equivariant model: points and joints of robots, symmetry, one set of weights, training."""

from __future__ import annotations

import pytest
import torch
from torch.distributions import Normal, kl_divergence

from pipeline.learning.eem.geometry import AXIS, PointGraph
from pipeline.learning.eem.network import Eem, Normals, divergence
from pipeline.learning.factory import build_network, make_objective, model_config
from robots import Robot, load_robot
from tests.samplers import SMALL, check_training, pose_set, train_config

VALUES = {**SMALL, "kind": "eem", "layers": 2, "latent": 2, "reconstruction_weight": 100.0}


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


def made(robot: Robot) -> Eem:
    torch.manual_seed(0)
    network = build_network(robot, model_config(VALUES))
    assert isinstance(network, Eem)
    return network


@pytest.mark.parametrize("name", ["nicol", "nico", "valkyrie", "panda", "fetch"])
def test_joints_follow_from_their_points(name: str) -> None:
    """Fetch has a joint that slides; points lie where forward kinematics of the robot has them."""
    robot = load_robot(name)
    graph = PointGraph(robot)
    poses, joints = pose_set(robot, 50)
    points = graph.points(joints)
    torch.testing.assert_close(graph.joints(points), joints, atol=2e-3, rtol=0)
    torch.testing.assert_close(points[:, -3] * graph.scale, poses[:, :3], atol=1e-4, rtol=0)
    given = graph.given(poses)
    known = graph.fixed > 0
    torch.testing.assert_close(given[:, known], points[:, known], atol=1e-3, rtol=0)
    assert int(known.sum()) >= 10, "base, tip, and the axes of the first and of the last joint"
    constant, lengths = graph.edges.unbind(dim=2)
    assert torch.allclose(lengths[3, 4], torch.tensor(AXIS), atol=1e-4)
    apart = torch.cdist(points, points)
    torch.testing.assert_close(apart * constant, lengths.expand_as(apart), atol=2e-3, rtol=0)


def test_joints_of_points_that_are_off_are_the_nearest(panda: Robot) -> None:
    """Noise of a hundredth of the reach: the angle's error is that noise over the lever."""
    graph = PointGraph(panda)
    _, joints = pose_set(panda, 50)
    generator = torch.Generator().manual_seed(0)
    noise = 0.01 * torch.randn(50, graph.count, 3, generator=generator)
    found = graph.joints(graph.points(joints) + noise)
    assert float((found - joints).abs().median()) < 3 * 0.01 / AXIS


@torch.no_grad()
def test_turned_and_shifted_points_are_decoded_turned_and_shifted(panda: Robot) -> None:
    network = made(panda)
    poses, _ = pose_set(panda, 3)
    given = network.graph.given(poses)
    latents = torch.randn(3, len(network.graph.unknown), 2)
    turn, _ = torch.linalg.qr(torch.randn(3, 3))
    shift = torch.tensor([0.3, -1.0, 2.0])
    decoded = network.decoded(given, latents)
    moved = network.decoded(given @ turn.T + shift, latents)
    torch.testing.assert_close(moved, decoded @ turn.T + shift, atol=1e-4, rtol=0)
    prior, there = network.priors(given), network.priors(given @ turn.T + shift)
    torch.testing.assert_close(there.mean, prior.mean, atol=1e-4, rtol=0)
    known = network.graph.fixed > 0
    torch.testing.assert_close(decoded[:, known], given[:, known])
    assert not torch.allclose(decoded, given)


def test_weights_of_one_robot_fit_another(panda: Robot) -> None:
    network, other = made(panda), made(load_robot("nico"))
    with torch.no_grad():
        for parameter in network.parameters():
            parameter.add_(0.1)
    other.load_state_dict(dict(network.named_parameters()), strict=False)
    assert all(
        torch.equal(mine, theirs)
        for mine, theirs in zip(network.parameters(), other.parameters(), strict=True)
    )


def test_the_divergence_is_that_of_the_library() -> None:
    torch.manual_seed(0)
    mine, other = (Normals(torch.randn(4, 3, 2), torch.randn(4, 3, 2)) for _ in range(2))
    expected = kl_divergence(
        Normal(mine.mean, mine.log_scale.exp()), Normal(other.mean, other.log_scale.exp())
    ).sum(dim=(1, 2))
    torch.testing.assert_close(divergence(mine, other), expected)


def test_the_loss_falls(panda: Robot) -> None:
    network = made(panda)
    objective = make_objective(panda, network, train_config(), torch.device("cpu"), seed=3)
    first, last = check_training(objective, network, pose_set(panda, 32), steps=40)
    assert last < 0.92 * first
