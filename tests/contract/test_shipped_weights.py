"""The weights that come with the project: small, right after installation, as good as they say."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from pipeline import load_solver
from pipeline.learning.card import read_card, shipped_weights
from pipeline.learning.weights import WEIGHTS
from robots import available_robots, load_robot, rotations

LARGEST_BYTES = 3_000_000
POSES = 1000


@pytest.fixture(autouse=True)
def nothing_trained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pipeline.loading.results", lambda: tmp_path)


@pytest.mark.parametrize("name", available_robots())
def test_they_are_small_and_as_precise_as_their_card_says(name: str) -> None:
    robot = load_robot(name)
    folder = shipped_weights(name)
    assert (folder / WEIGHTS).stat().st_size <= LARGEST_BYTES
    said = read_card(folder)["test"]
    joints = robot.sample(POSES, seed=123, workspace_filter=name == "nicol")
    poses = robot.forward_kinematics(joints)
    solution = load_solver("cycleik", robot).solve(poses)
    reached = robot.forward_kinematics(solution.joints)
    position = 1e3 * np.linalg.norm(reached[:, :3] - poses[:, :3], axis=1).mean()
    rotation = np.degrees(rotations.rotation_angle(reached[:, 3:], poses[:, 3:])).mean()
    # Means of 1,000 poses of a skewed distribution; the card's are of 5,000 others.
    assert position < 1.3 * said["position_error_mm"]
    assert rotation < 1.3 * said["rotation_error_deg"]


@pytest.mark.parametrize("name", available_robots())
def test_refined_they_solve_every_pose(name: str) -> None:
    robot = load_robot(name)
    poses = robot.forward_kinematics(robot.sample(POSES, seed=7, workspace_filter=name == "nicol"))
    solution = load_solver("cycleik_refined", robot).solve(poses)
    plain = load_solver("lm", robot).solve(poses)
    assert solution.found.mean() >= 0.999
    assert solution.iterations.mean() < 0.5 * plain.iterations.mean()
