"""The normalizing flow: a density that is one, draws that belong to it, and its training."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from baselines import PoseError, SettingError
from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.errors import ConfigError
from pipeline.learning.card import WeightsError, chain_facts
from pipeline.learning.factory import build_network, make_objective
from pipeline.learning.flow.network import FlowNetwork
from pipeline.learning.flow.objective import FlowObjective
from pipeline.learning.flow.solver import FlowIk
from pipeline.learning.networks import HALF_WIDTH, parameter_count
from pipeline.learning.weights import save_weights
from pipeline.loading import load_solver
from pipeline.stages import running
from robots import Robot, load_robot, rotations

SMALL = ["model=flow", "model.hidden=[16]", "model.width=16", "model.encoder=[16]"]
CPU = torch.device("cpu")


@pytest.fixture(scope="module", params=["nico", "panda"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


@pytest.fixture
def network(robot: Robot) -> FlowNetwork:
    """A flow whose couplings are not the identity that they start from."""
    torch.manual_seed(0)
    network = build_network(robot, compose(SMALL).model)
    assert isinstance(network, FlowNetwork)
    with torch.no_grad():
        for parameter in network.parameters():
            parameter += 0.05 * torch.randn_like(parameter)
    return network


def pose_set(robot: Robot, count: int) -> tuple[torch.Tensor, torch.Tensor]:
    joints = robot.sample(count, seed=1)
    poses = robot.forward_kinematics(joints)
    return torch.tensor(poses, dtype=torch.float32), torch.tensor(joints, dtype=torch.float32)


def test_the_density_is_that_of_the_change_of_variables(robot: Robot, network: FlowNetwork) -> None:
    """Against the determinant of the Jacobian by automatic differentiation, in float64."""
    network.double()
    poses, joints = (values.double() for values in pose_set(robot, 1))
    density = network.density(poses, torch.full((1, 1), 0.3, dtype=torch.float64))
    unit = HALF_WIDTH * network.unit(joints)
    to_base = density.transform
    jacobian = torch.autograd.functional.jacobian(to_base, unit)[0, :, 0]
    expected = density.base.log_prob(to_base(unit)) + torch.linalg.slogdet(jacobian).logabsdet
    torch.testing.assert_close(density.log_prob(unit), expected)
    torch.testing.assert_close(to_base.inv(to_base(unit)), unit)


def test_draws_follow_the_density(robot: Robot, network: FlowNetwork) -> None:
    """Mean and variance of our draws against those of the library's, which take other numbers."""
    poses, _ = pose_set(robot, 1)
    drawn = network.draws(poses, network.latents(1, 20000, seed=5))[0]
    torch.manual_seed(6)
    with torch.no_grad():
        theirs = network.density(poses, torch.zeros(1, 1)).sample((20000,))[:, 0]
    unit = HALF_WIDTH * network.unit(drawn)
    inside = theirs.clamp(-HALF_WIDTH, HALF_WIDTH)
    torch.testing.assert_close(unit.mean(0), inside.mean(0), atol=0.05, rtol=0)
    torch.testing.assert_close(unit.std(0), inside.std(0), atol=0.05, rtol=0)


def test_the_loss_falls_and_follows_from_the_step_alone() -> None:
    robot = load_robot("panda")
    torch.manual_seed(0)
    config = compose(SMALL)
    network = build_network(robot, config.model)
    objective = make_objective(robot, network, config.train, CPU, seed=3)
    assert isinstance(objective, FlowObjective)
    poses, joints = pose_set(robot, 256)
    first = objective.loss(poses, joints, 0, 0.0)
    assert torch.equal(first, objective.loss(poses, joints, 0, 0.0))
    assert not torch.equal(first, objective.loss(poses, joints, 1, 0.0))
    optimizer = torch.optim.Adam(network.parameters(), lr=5e-3)
    for step in range(60):
        optimizer.zero_grad()
        loss = objective.loss(poses, joints, step, step / 60)
        loss.backward()
        optimizer.step()
    assert torch.isfinite(loss)
    assert loss < first - 1.0
    position, rotation = objective.errors(poses)
    assert position.shape == rotation.shape == (256,)
    assert torch.equal(position, objective.errors(poses)[0])


def test_a_mixture_picks_components_as_often_as_they_weigh() -> None:
    robot = load_robot("panda")
    torch.manual_seed(0)
    network = build_network(robot, compose([*SMALL, "model.components=2"]).model)
    assert isinstance(network, FlowNetwork)
    last = network.flow.base.hyper[-1]
    dof = robot.dof
    with torch.no_grad():
        last.weight.zero_()
        last.bias[:2] = torch.tensor([np.log(0.8), np.log(0.2)])
        last.bias[2 : 2 + dof] = -1.0
        last.bias[2 + dof : 2 + 2 * dof] = 1.0
        last.bias[2 + 2 * dof :] = np.log(0.01)
    poses, _ = pose_set(robot, 1)
    unit = network.unit(network.draws(poses, network.latents(1, 4000, seed=1))[0])
    assert ((unit > 0).all(dim=1) | (unit < 0).all(dim=1)).all()
    assert (unit[:, 0] < 0).float().mean().item() == pytest.approx(0.8, abs=0.03)


def test_the_published_size_builds() -> None:
    """By hand: 24 couplings, layers 195-1024-1024-1024-8 or 196-1024-1024-1024-6, with biases."""
    network = build_network(load_robot("panda"), compose(["model=ikflow"]).model)
    assert isinstance(network, FlowNetwork)
    between = 2 * (1024 * 1024 + 1024)
    small = (192 + 3) * 1024 + 1024 + between + 1025 * 2 * 4
    large = (192 + 4) * 1024 + 1024 + between + 1025 * 2 * 3
    base = 193 * (1 + 7 + 7)
    assert parameter_count(network.flow) == 12 * (small + large) + base


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("model.couplings=0", "model.couplings"),
        ("model.components=0", "model.components"),
        ("model.noise=-1", "model.noise"),
        ("model.encoder=[0]", "model.encoder"),
    ],
)
def test_values_that_cannot_be_are_refused(override: str, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        compose(["model=flow", override])


def test_the_solver_draws_and_answers_with_the_best_draw(tmp_path: Path) -> None:
    robot = load_robot("panda")
    torch.manual_seed(0)
    config = compose(SMALL)
    card = {**chain_facts(robot), "config": {"model": to_dict(config.model)}}
    save_weights(tmp_path, build_network(robot, config.model), card)
    solver = load_solver("flow", robot, tmp_path, samples=30)
    assert isinstance(solver, FlowIk)
    poses = robot.forward_kinematics(robot.sample(6, seed=4))
    drawn = solver.sample(poses, 30, solver.seed)
    assert drawn.shape == (6, 30, robot.dof)
    assert (drawn >= robot.lower).all() and (drawn <= robot.upper).all()
    assert len(np.unique(drawn[0, :, 0])) == 30
    np.testing.assert_allclose(solver.sample(poses[2], 30, solver.seed), drawn[2], atol=1e-5)
    assert not np.array_equal(solver.sample(poses, 30, solver.seed + 1), drawn)
    answers = solver.solve(poses).joints
    reached = robot.forward_kinematics(drawn.reshape(-1, robot.dof)).reshape(6, 30, 7)
    wanted = np.broadcast_to(poses[:, None, 3:], (6, 30, 4))
    angle = rotations.rotation_angle(reached[..., 3:], wanted)
    distance = np.linalg.norm(reached[..., :3] - poses[:, None, :3], axis=2)
    best = (distance / 0.010 + np.degrees(angle) / 20).argmin(axis=1)
    np.testing.assert_array_equal(answers, drawn[np.arange(6), best])
    with pytest.raises(PoseError):
        solver.sample(poses * 2, 3, 0)
    narrow = load_solver("flow", robot, tmp_path, latent_scale=0.05)
    wide = load_solver("flow", robot, tmp_path, latent_scale=1.0)
    assert isinstance(narrow, FlowIk) and isinstance(wide, FlowIk)
    deviation = [part.sample(poses, 30, 0).std(axis=1).mean() for part in (narrow, wide)]
    assert deviation[0] < deviation[1]
    for setting in ({"samples": 0}, {"latent_scale": -1.0}):
        with pytest.raises(SettingError, match=next(iter(setting))):
            load_solver("flow", robot, tmp_path, **setting)
    with pytest.raises(WeightsError, match="of kind 'flow', expected one of mlp"):
        load_solver("cycleik", robot, tmp_path)


def test_a_run_of_another_model_trains_the_flow_for_its_solver(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    requested = []

    monkeypatch.setattr(running, "run_stage", lambda name, config: requested.append(config))
    for override, name in (("compact", "flow"), ("flow", "flow"), ("tiny", "cycleik")):
        values = [f"model={override}", "train.epochs=2", f"results_dir={tmp_path}"]
        running.weights_of(name, compose(values))
    assert [config.model.name for config in requested] == ["flow", "flow", "tiny"]
    assert [config.train.epochs for config in requested] == [2, 2, 2]
    assert requested[0].train.batch_size == compose(["model=flow"]).train.batch_size
