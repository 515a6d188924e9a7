"""The continuous flow: its density, its integration, and its training."""

from __future__ import annotations

import math

import pytest
import torch

from pipeline.learning.factory import build_network, make_objective, model_config
from pipeline.learning.node_ik.network import NodeIk
from robots import Robot, load_robot
from tests.samplers import SMALL, check_training, pose_set, train_config

VALUES = {**SMALL, "kind": "node_ik", "steps": 8, "probes": 1, "noise": 0.01}


@pytest.fixture(scope="module")
def nico() -> Robot:
    return load_robot("nico")


@pytest.fixture
def network(nico: Robot) -> NodeIk:
    """A flow that is not the identity that it starts from."""
    torch.manual_seed(0)
    network = build_network(nico, model_config(VALUES))
    assert isinstance(network, NodeIk)
    with torch.no_grad():
        for parameter in network.parameters():
            parameter += 0.2 * torch.randn_like(parameter)
    return network.double()


@torch.no_grad()
def test_the_density_is_that_of_the_change_of_variables(nico: Robot, network: NodeIk) -> None:
    """With directions along the axes the trace is exact: against the Jacobian of the whole map."""
    poses = pose_set(nico, 1)[0].double()
    noise = torch.randn(1, nico.dof, dtype=torch.float64)
    joints = network.transformed(poses, noise.unsqueeze(1)).squeeze(1)
    axes = math.sqrt(nico.dof) * torch.eye(nico.dof, dtype=torch.float64).unsqueeze(0)
    density, back = network.log_density(poses, joints, torch.zeros(1, 1).double(), axes)
    torch.testing.assert_close(back, noise, atol=1e-5, rtol=0)
    with torch.enable_grad():
        jacobian = torch.autograd.functional.jacobian(
            lambda x: network.transformed(poses, x.view(1, 1, -1)).view(-1), noise[0]
        )
    normal = torch.distributions.Normal(0, 1).log_prob(noise).sum()
    expected = normal - torch.linalg.slogdet(jacobian).logabsdet
    assert float(density) == pytest.approx(float(expected), abs=1e-4)


@torch.no_grad()
def test_the_trace_is_estimated_without_bias(nico: Robot, network: NodeIk) -> None:
    poses, joints = (values.double() for values in pose_set(nico, 1))
    axes = math.sqrt(nico.dof) * torch.eye(nico.dof, dtype=torch.float64).unsqueeze(0)
    share = torch.full((1, 1), 0.5, dtype=torch.float64)
    exact, _ = network.log_density(poses, network.unit(joints), share, axes)
    generator = torch.Generator().manual_seed(1)
    probes = torch.randn(1, 20000, nico.dof, generator=generator, dtype=torch.float64)
    estimate, _ = network.log_density(poses, network.unit(joints), share, probes)
    assert float(estimate) == pytest.approx(float(exact), abs=0.05)


@torch.no_grad()
def test_half_the_step_leaves_a_sixteenth_of_the_error(nico: Robot, network: NodeIk) -> None:
    poses = pose_set(nico, 4)[0].double()
    noise = torch.randn(4, 3, nico.dof, dtype=torch.float64)

    def at(steps: int) -> torch.Tensor:
        network.steps = steps
        return network.transformed(poses, noise)

    exact, errors = at(64), []
    for steps in (4, 8):
        errors.append(float((at(steps) - exact).norm()))
    assert errors[0] / errors[1] == pytest.approx(16, rel=0.35)


def test_the_loss_falls(nico: Robot) -> None:
    torch.manual_seed(0)
    network = build_network(nico, model_config({**VALUES, "steps": 2}))
    objective = make_objective(nico, network, train_config(), torch.device("cpu"), seed=3)
    first, last = check_training(objective, network, pose_set(nico, 128), steps=60)
    assert last < first - 0.5
