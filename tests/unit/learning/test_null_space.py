"""Null-space generators: noise gives other solutions, training spreads them and resumes bitwise."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import torch

from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.data.dataset import PoseSet
from pipeline.learning.card import chain_facts
from pipeline.learning.factory import build_network, make_objective
from pipeline.learning.networks import parameter_count
from pipeline.learning.null_space.network import NullSpaceGenerator
from pipeline.learning.null_space.objective import NullSpaceObjective, variance_loss
from pipeline.learning.null_space.solver import NullSpaceIk
from pipeline.learning.trainer import Trainer, TrainingRun
from pipeline.learning.weights import save_weights
from pipeline.loading import load_solver
from pipeline.settings import Config
from robots import Robot, load_robot

CPU = torch.device("cpu")
SMALL = ["model=null_space", "model.hidden=[32]", "model.width=32", "train.batch_size=25"]


@pytest.fixture(scope="module")
def panda() -> Robot:
    return load_robot("panda")


@pytest.fixture(scope="module")
def poses(panda: Robot) -> PoseSet:
    joints = panda.sample(500, seed=1, collision_free=False)
    return PoseSet(panda.forward_kinematics(joints), joints)


@pytest.fixture(scope="module")
def weights(panda: Robot, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("weights")
    config = compose(SMALL)
    card = {**chain_facts(panda), "config": {"model": to_dict(config.model)}}
    save_weights(folder, network(panda, config), card)
    return folder


@pytest.fixture(scope="module")
def solver(panda: Robot, weights: Path) -> NullSpaceIk:
    made = load_solver("null_space", panda, weights)
    assert isinstance(made, NullSpaceIk)
    return made


def network(robot: Robot, config: Config) -> NullSpaceGenerator:
    torch.manual_seed(3)
    made = build_network(robot, config.model)
    assert isinstance(made, NullSpaceGenerator)
    return made


def test_the_paper_s_generator_has_its_layers_and_takes_the_noise_beside_the_pose() -> None:
    nicol = load_robot("nicol")
    made = network(nicol, compose(["robot=nicol", "experiment=null_space_paper"]))
    sizes = [7 + 8, 1180, 1170, 2500, 1290, 700, 970, 440, 770, 8]
    expected = sum((a + 1) * b for a, b in pairwise(sizes))
    assert parameter_count(made) == expected


@pytest.mark.parametrize("model", ["null_space", "null_space_paper"])
def test_answers_keep_the_limits_and_follow_the_noise(
    panda: Robot, poses: PoseSet, model: str
) -> None:
    made = network(panda, compose([f"model={model}", "model.hidden=[32,32]"]))
    batch = torch.as_tensor(poses.poses, dtype=torch.float32)
    one, two = (made.answers(batch, torch.full((500, 7), value)) for value in (0.1, 0.9))
    assert not torch.allclose(one, two)
    assert (
        (one >= made.joint_centre - made.joint_scale)
        & (one <= made.joint_centre + made.joint_scale)
    ).all()
    middle = made.answers(batch, torch.full((500, 7), 0.5))
    torch.testing.assert_close(made(batch), middle.unsqueeze(1))


def test_the_variance_term_is_zero_at_the_variance_of_the_noise() -> None:
    # Two answers d apart have the variance d^2 / 2; the mean over joints counts.
    apart = (1 / 6) ** 0.5
    right = torch.tensor([[[0.0, 0.0], [apart, apart]]])
    torch.testing.assert_close(
        variance_loss(right, each=False), torch.tensor(0.0), atol=1e-7, rtol=0
    )
    one_joint = torch.tensor([[[0.0, 5.0], [2**0.5 * apart, 5.0]]])
    torch.testing.assert_close(
        variance_loss(one_joint, each=False), torch.tensor(0.0), atol=1e-7, rtol=0
    )
    # Joint by joint the first is 1/6 - 1/12 too wide and the second 1/12 too narrow.
    torch.testing.assert_close(variance_loss(one_joint, each=True), torch.tensor(1 / 12))
    same = torch.ones(4, 8, 2)
    torch.testing.assert_close(variance_loss(same, each=False), torch.tensor(1 / 12))


def test_the_noise_follows_from_seed_and_step_alone(panda: Robot, poses: PoseSet) -> None:
    config = compose(SMALL)
    batch = torch.as_tensor(poses.poses[:25], dtype=torch.float32)
    joints = torch.as_tensor(poses.joints[:25], dtype=torch.float32)
    values = []
    for seed, step in ((0, 4), (0, 4), (0, 5), (1, 4)):
        objective = make_objective(panda, network(panda, config), config.train, CPU, seed)
        assert isinstance(objective, NullSpaceObjective)
        values.append(float(objective.loss(batch, joints, step, 0.0).detach()))
    assert values[0] == values[1]
    assert len(set(values)) == 3


def test_networks_without_an_objective_are_refused(panda: Robot) -> None:
    with pytest.raises(TypeError, match="Linear"):
        make_objective(panda, torch.nn.Linear(7, 7), compose().train, CPU)


def test_training_spreads_the_answers(panda: Robot, poses: PoseSet) -> None:
    spread = {}
    for weight in (0, 50):
        overrides = [f"train.variance_weight={weight}", "train.epochs=8", "train.validations=1"]
        config = compose([*SMALL, *overrides, "train.warm_up_steps=0"])
        trainer = Trainer(panda, network(panda, config), config.train, TrainingRun(0, "", "spread"))
        trainer.fit(poses, PoseSet(poses.poses[:50], poses.joints[:50]))
        batch = trainer.tensor(poses.poses[:50]).repeat_interleave(64, dim=0)
        made = trainer.network
        assert isinstance(made, NullSpaceGenerator)
        with torch.no_grad():
            answers = made.answers(batch, torch.rand(len(batch), 7)).unflatten(0, (50, 64))
        spread[weight] = float(answers.var(dim=1).mean())
    assert 0.5 / 12 < spread[50] < 1.5 / 12
    assert spread[0] < 0.5 * spread[50]


def test_a_killed_training_ends_with_the_same_bits(
    panda: Robot, poses: PoseSet, tmp_path: Path
) -> None:
    overrides = ["train.epochs=1", "train.validations=4", "train.checkpoint_s=1.0e-9"]
    config = compose([*SMALL, *overrides])
    whole = Trainer(panda, network(panda, config), config.train, TrainingRun(0, "d", "whole"))
    expected = whole.fit(poses, poses)

    def die(step: int, row: dict[str, float]) -> None:
        if step >= 10:
            raise KeyboardInterrupt

    path = tmp_path / "state.safetensors"
    first = Trainer(
        panda, network(panda, config), config.train, TrainingRun(0, "d", "first", path, report=die)
    )
    with pytest.raises(KeyboardInterrupt):
        first.fit(poses, poses)
    second = Trainer(
        panda, network(panda, config), config.train, TrainingRun(0, "d", "second", path)
    )
    assert second.fit(poses, poses).curve == expected.curve
    for name, value in whole.network.state_dict().items():
        assert torch.equal(value, second.network.state_dict()[name]), name


def test_samples_are_the_same_for_a_seed_and_the_first_is_the_answer(
    solver: NullSpaceIk, poses: PoseSet, panda: Robot
) -> None:
    drawn = solver.sample(poses.poses[:3], 10, seed=0)
    assert drawn.shape == (3, 10, 7)
    assert ((drawn >= panda.lower) & (drawn <= panda.upper)).all()
    assert len(np.unique(drawn[0].round(6), axis=0)) == 10
    one = solver.sample(poses.poses[1], 10, seed=0)
    np.testing.assert_allclose(one, drawn[1], atol=1e-6)
    assert not np.allclose(solver.sample(poses.poses[1], 10, seed=1), one)
    np.testing.assert_allclose(solver.solve(poses.poses[:3]).joints, drawn[:, 0], atol=1e-6)


def test_refined_answers_reach_the_pose(weights: Path, poses: PoseSet, panda: Robot) -> None:
    solution = load_solver("null_space_refined", panda, weights).solve(poses.poses[:50])
    assert solution.found.all()
    reached = panda.forward_kinematics(solution.joints)
    assert np.abs(reached[:, :3] - poses.poses[:50, :3]).max() < 1e-4
