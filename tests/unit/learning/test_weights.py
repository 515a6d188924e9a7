"""Weights on disk: they come back as they were, and never for another robot."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.errors import ConfigError
from pipeline.learning.card import WeightsError, chain_facts, shipped_weights
from pipeline.learning.cycleik.solver import CycleIk
from pipeline.learning.factory import build_network
from pipeline.learning.networks import IkNetwork
from pipeline.learning.weights import WEIGHTS, load_network, save_weights
from pipeline.loading import find_weights, load_solver
from pipeline.solvers import models_of
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
        robot,
        str(tmp_path),
        cells=1,
        precision="float64",
        position_tolerance_mm=400,
        rotation_tolerance_deg=90,
        threads=0,
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


def test_a_plain_network_computes_in_float32_unless_told(tmp_path: Path, robot: Robot) -> None:
    stored(tmp_path, robot, "tiny")
    poses = robot.forward_kinematics(robot.sample(100, seed=7, collision_free=False))
    answers = {
        precision: load_solver("cycleik", robot, weights=str(tmp_path), precision=precision)
        .solve(poses)
        .joints
        for precision in ("auto", "float32", "float64")
    }
    np.testing.assert_array_equal(answers["auto"], answers["float32"])
    assert 1e-12 < np.abs(answers["float64"] - answers["float32"]).max() < 1e-4


def keep(folder: Path, robot: Robot, kind: str, **model: object) -> Path:
    """Weights of one layer with a card of a network of some kind."""
    card = {**chain_facts(robot), "config": {"model": {"kind": kind, **model}}}
    save_weights(folder, torch.nn.Linear(1, 1), card)
    return folder


def test_weights_of_another_kind_are_refused(tmp_path: Path, robot: Robot) -> None:
    folder = keep(tmp_path, robot, "another")
    with pytest.raises(WeightsError, match="kind 'another', expected one of mlp"):
        load_network(folder, robot, models_of("cycleik")[0])


def test_those_of_the_own_profile_come_first_then_the_projects_and_no_others(
    tmp_path: Path, robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.loading.results", lambda: tmp_path)
    shipped = shipped_weights("panda")
    toy = keep(tmp_path / "smoke" / "train" / "panda" / "tiny", robot, "mlp")
    keep(tmp_path / "quick" / "train" / "panda" / "small_mlp", robot, "mlp")
    assert find_weights("cycleik", robot) == shipped, "neither a toy nor another experiment's"
    assert find_weights("cycleik", robot, profile="smoke") == toy
    assert find_weights("cycleik", robot, profile="paper") == shipped
    keep(tmp_path / "quick" / "train" / "panda" / "compact", robot, "flow")
    assert find_weights("cycleik", robot) == shipped, "of another kind"
    own = keep(tmp_path / "quick" / "train" / "panda" / "compact", robot, "experts")
    assert find_weights("cycleik", robot) == own
    with pytest.raises(WeightsError, match=r"kind flow for panda.*model=flow profile=quick"):
        find_weights("flow", robot)
    with pytest.raises(ConfigError, match="did you mean 'quick'"):
        find_weights("cycleik", robot, profile="quik")


def test_the_weights_that_are_named_are_taken_and_the_solver_says_which(
    tmp_path: Path, robot: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pipeline.loading.results", lambda: tmp_path)
    shipped = shipped_weights("panda")
    assert load_solver("cycleik", robot).weights == shipped
    copy = tmp_path / "mine"
    shutil.copytree(shipped, copy)
    for named in (copy, str(copy), copy / WEIGHTS):
        assert load_solver("cycleik", robot, weights=named).weights == copy
    assert load_solver("lm", robot).weights is None
    with pytest.raises(ConfigError, match="'lm' is not neural"):
        load_solver("lm", robot, weights=copy)
    with pytest.raises(WeightsError, match="no trained weights in"):
        load_solver("cycleik", robot, weights=tmp_path / "nothing")
