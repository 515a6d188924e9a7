"""Weights on disk: they come back as they were, and never for another robot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.learning.networks import IkNetwork, build_network
from pipeline.learning.solver import CycleIk
from pipeline.learning.weights import WeightsError, chain_facts, load_network, save_weights
from pipeline.solvers import find_weights, models_of
from robots import Robot, load_robot


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("panda")


def stored(folder: Path, robot: Robot, model: str = "tiny") -> IkNetwork:
    config = compose([f"model={model}"])
    torch.manual_seed(0)
    network = build_network(robot, config.model)
    card = {**chain_facts(robot), "config": {"model": to_dict(config.model)}}
    save_weights(folder, network, card)
    return network


@pytest.mark.parametrize("model", ["tiny", "compact"])
def test_a_network_comes_back_as_it_was(tmp_path: Path, robot: Robot, model: str) -> None:
    network = stored(tmp_path, robot, model)
    poses = torch.as_tensor(robot.forward_kinematics(robot.sample(8)), dtype=torch.float32)
    assert torch.equal(load_network(tmp_path, robot)(poses), network(poses))


def test_half_precision_keeps_scalings_and_rounds_weights(tmp_path: Path, robot: Robot) -> None:
    config = compose(["model=compact"])
    network = build_network(robot, config.model)
    card = {**chain_facts(robot), "config": {"model": to_dict(config.model)}}
    save_weights(tmp_path, network, card, half=True)
    loaded = load_network(tmp_path, robot)
    trained = dict(network.named_parameters())
    for name, value in loaded.state_dict().items():
        assert value.dtype == torch.float32
        wanted = network.state_dict()[name]
        assert torch.equal(value, wanted.half().float() if name in trained else wanted)
    size = (tmp_path / "weights.safetensors").stat().st_size
    assert size < 1.01 * 2 * sum(value.numel() for value in trained.values())


def test_weights_of_another_robot_are_refused_by_name(tmp_path: Path, robot: Robot) -> None:
    stored(tmp_path, robot)
    with pytest.raises(WeightsError, match=r"robot is 'panda' there, 'nico' here"):
        load_network(tmp_path, load_robot("nico"))


def test_edited_weights_are_noticed(tmp_path: Path, robot: Robot) -> None:
    stored(tmp_path, robot)
    path = tmp_path / "weights.safetensors"
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(bytes(content))
    with pytest.raises(WeightsError, match="train again"):
        load_network(tmp_path, robot)


def test_missing_weights_say_how_to_make_them(tmp_path: Path, robot: Robot) -> None:
    with pytest.raises(WeightsError, match="no trained weights"):
        load_network(tmp_path, robot)


def test_the_solver_takes_the_best_hypothesis_and_claims_what_is_true(
    tmp_path: Path, robot: Robot
) -> None:
    network = stored(tmp_path, robot, "compact")
    joints = robot.sample(200, seed=5)
    poses = robot.forward_kinematics(joints)
    solver = CycleIk(
        robot, str(tmp_path), position_tolerance_mm=400, rotation_tolerance_deg=90, threads=0
    )
    solution = solver.solve(poses)
    reached = robot.forward_kinematics(solution.joints)
    error_mm = 1e3 * np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
    hypotheses = network(torch.as_tensor(poses, dtype=torch.float32)).detach().numpy()
    in_one_of_them = np.abs(hypotheses - solution.joints[:, None]).max(axis=2).min(axis=1)
    assert in_one_of_them.max() < 1e-4  # the kernel's tanh is a fraction of polynomials
    assert (error_mm[solution.found] <= 400).all()
    assert 0 < solution.found.sum() < len(poses)
    assert len(solver.solve(np.empty((0, 7)))) == 0


def test_a_solver_takes_weights_of_its_own_kinds_only(
    tmp_path: Path, robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.solvers.RESULTS", tmp_path)
    folder = tmp_path / "quick" / "train" / "panda"
    for name, kind in (("a", "another"), ("tiny", "mlp")):
        save_weights(folder / name, torch.nn.Linear(1, 1), {"config": {"model": {"kind": kind}}})
    kinds, model = models_of("cycleik")
    assert find_weights("panda", kinds, model) == folder / "tiny"
    assert find_weights("panda", ("another",), model) == folder / "a"
    with pytest.raises(WeightsError, match=r"kind other for panda; train .* model=some"):
        find_weights("panda", ("other",), "some")
    card = {**chain_facts(robot), "config": {"model": {"kind": "another"}}}
    save_weights(folder / "a", torch.nn.Linear(1, 1), card)
    with pytest.raises(WeightsError, match="kind 'another', expected one of mlp"):
        load_network(folder / "a", robot, kinds)
