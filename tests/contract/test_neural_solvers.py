"""What every solver must do, for those that need trained weights."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import torch

import baselines
from baselines import Budget, PoseError, SolverError
from baselines.registry import settings
from pipeline.config import compose
from pipeline.containers import to_dict
from pipeline.learning.card import chain_facts
from pipeline.learning.config import ModelConfig
from pipeline.learning.factory import build_network
from pipeline.learning.weights import save_weights
from pipeline.loading import load_solver
from pipeline.solvers import is_neural, models_of
from robots import Robot, load_robot, rotations

NEURAL = [name for name in baselines.names() if is_neural(name)]
REFINED = [name for name in NEURAL if name.endswith("_refined")]


@pytest.fixture(scope="module", params=["nico", "panda"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(request.param)


@pytest.fixture(scope="module")
def weights(robot: Robot, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Untrained weights of the model of each solver: the contract does not ask for precision."""
    folders = {}
    for model in sorted({models_of(name)[1] for name in NEURAL}):
        folders[model] = folder = tmp_path_factory.mktemp("weights")
        small = small_model(model)
        torch.manual_seed(0)
        card = {**chain_facts(robot), "config": {"model": to_dict(small)}}
        save_weights(folder, build_network(robot, small), card)
    return {name: folders[models_of(name)[1]] for name in NEURAL}


@cache
def small_model(name: str) -> ModelConfig:
    return compose([f"model={name}", "model.hidden=[32]", "model.width=16"]).model


@pytest.mark.parametrize("name", NEURAL)
def test_the_contract_of_a_solver(name: str, robot: Robot, weights: dict[str, Path]) -> None:
    solver = load_solver(name, robot, weights[name])
    poses = robot.forward_kinematics(robot.sample(40, seed=2))
    solution = solver.solve(poses)
    assert solution.joints.shape == (40, robot.dof)
    assert (solution.joints >= robot.lower).all()
    assert (solution.joints <= robot.upper).all()
    assert (solution.time_s > 0).all()
    assert all(
        (reason == "") == good for reason, good in zip(solution.reason, solution.found, strict=True)
    )
    again = solver.solve(poses)
    np.testing.assert_array_equal(solution.joints, again.joints)
    negated = poses.copy()
    negated[:, 3:] *= -1
    assert solver.solve(negated).found.tolist() == solution.found.tolist()
    assert len(solver.solve(np.empty((0, 7)))) == 0
    with pytest.raises(PoseError):
        solver.solve(np.full((1, 7), np.nan))
    with pytest.raises(PoseError, match="unit"):
        solver.solve(poses * 2)


@pytest.mark.parametrize("name", REFINED)
def test_refinement_reaches_the_tolerance_from_an_untrained_network(
    name: str, robot: Robot, weights: dict[str, Path]
) -> None:
    solver = load_solver(name, robot, weights[name])
    joints = robot.sample(100, seed=3)
    poses = robot.forward_kinematics(joints)
    solution = solver.solve(poses)
    reached = robot.forward_kinematics(solution.joints)
    assert solution.found.all()
    assert np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).max() < 1e-4
    assert rotations.rotation_angle(reached[:, 3:], poses[:, 3:]).max() < 1e-4
    near = solver.solve(poses, initial=joints)
    assert np.abs(near.joints - joints).max() < 1e-6, "an initial guess is the first seed"
    assert near.iterations.max() <= 1
    far = robot.forward_kinematics(joints)
    far[:, 0] += 5.0
    missed = solver.solve(far, budget=Budget(iterations=30))
    assert not missed.found.any()
    assert missed.iterations.max() <= 30


def test_a_neural_solver_without_weights_says_how_to_train(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipeline.loading.results", lambda: Path("nowhere"))
    with pytest.raises(ValueError, match="pipeline train robot=fetch model=flow"):
        load_solver("flow", load_robot("fetch"))  # no flow comes with the project
    with pytest.raises(SolverError, match="did you mean 'cycleik'"):
        load_solver("cycleikk", load_robot("fetch"))
    assert settings("cycleik")["weights"] == ""


@pytest.mark.parametrize("name", REFINED)
def test_what_a_refined_solver_calls_found_is_within_its_own_tolerances_where_they_are_tighter(
    name: str, robot: Robot, weights: dict[str, Path]
) -> None:
    poses = robot.forward_kinematics(robot.sample(20, seed=3))
    for distance_mm, angle_deg in ((1e-4, 1e-4), (10.0, 20.0), (1e-4, 20.0)):
        solver = load_solver(
            name,
            robot,
            weights[name],
            position_tolerance_mm=distance_mm,
            rotation_tolerance_deg=angle_deg,
        )
        solution = solver.solve(poses)
        reached = robot.forward_kinematics(solution.joints)
        distance = np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1)
        angle = rotations.rotation_angle(reached[:, 3:], poses[:, 3:])
        assert solution.found.any()
        assert (distance[solution.found] <= min(1e-4, distance_mm / 1e3) * 1.001 + 1e-12).all()
        limit = min(1e-4, np.radians(angle_deg))
        assert (angle[solution.found] <= limit * 1.001 + 1e-9).all()
