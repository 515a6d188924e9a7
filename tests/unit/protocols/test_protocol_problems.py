"""What protocols ask: each YAML composes, targets and starts are what it says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pipeline.config import compose, group_choices
from pipeline.errors import ConfigError
from pipeline.protocols.problems import axis_errors, questions, with_protocol
from pipeline.reporting.topics.protocols import ORDER
from robots import Robot, load_robot
from robots.rotations import quaternion_from_rotation_vector, quaternion_multiply
from tests.protocol_rows import protocol, protocol_of

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot(urdf=TWO_LINK)


def ask(robot: Robot, **changes: object) -> np.ndarray:
    asked = questions(robot, protocol(most_poses=50, **changes), 0, False)
    assert asked.start is not None
    return asked.start


@pytest.mark.parametrize("name", group_choices("protocol"))
def test_each_protocol_fits_every_scale(name: str) -> None:
    for most in (1, 20, 1000, 200_000):
        made = protocol_of(name, most)
        assert made.name == name
        assert made.targets_at_most == min(most, made.poses)
        assert made.ranking_batch() in made.calls()


def test_the_six_are_those_of_the_sources() -> None:
    assert sorted(ORDER) == group_choices("protocol")
    made = {name: protocol_of(name, 1000) for name in ORDER}
    assert {name: (p.start, p.time_s) for name, p in made.items()} == {
        "cycleik": ("home", 1e-3),
        "trac_ik": ("middle", 5e-3),
        "ikflow": ("random", None),
        "curobo": ("none", None),
        "hjcd_ik": ("random", None),
        "frankik": ("home", None),
    }
    success = {name: p.success for name, p in made.items() if p.success.errors != "none"}
    assert {name: (s.errors, s.position_mm) for name, s in success.items()} == {
        "cycleik": ("axes_mean", 10.0),
        "trac_ik": ("each_axis", 0.01),
        "curobo": ("euclidean", 5.0),
    }
    assert np.deg2rad(success["trac_ik"].rotation_deg or 0.0) == pytest.approx(1e-5, rel=1e-12)
    assert np.deg2rad(success["curobo"].rotation_deg or 0.0) == pytest.approx(0.05, rel=1e-12)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("protocol.start=anywhere", "must be one of home, middle, random, none"),
        ("protocol.success.position_mm=null", "must be a number where errors is axes_mean"),
        ("protocol.success.errors=none", "rank.by=success needs protocol.success.errors"),
        ("protocol.solvers=[]", "must name at least one solver"),
        ("protocol.targets=near_home", "protocol.within_deg must not be empty"),
    ],
)
def test_what_cannot_be_is_refused(change: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        compose([change])


def test_batches_of_one_call_are_as_large_as_there_are_targets() -> None:
    batches = {"batch_sizes": [1, 10, 100], "ranked_batch": 100, "one_call": True}
    few = protocol(most_poses=20, **batches)
    assert few.calls() == {1: 1, 10: 10}
    assert few.ranking_batch() == 10
    assert protocol(**batches).calls() == {1: 1, 10: 10, 100: 100}
    all_targets = protocol(batch_sizes=[10], ranked_batch=10, draws=3, most_poses=7)
    assert all_targets.calls() == {10: 21}


def test_every_answer_to_a_target_has_a_start_of_its_own(arm: Robot) -> None:
    asked = questions(arm, protocol(most_poses=5, draws=3, start="random"), 0, False)
    assert asked.start is not None
    assert len(asked.poses) == 15
    assert (asked.poses.reshape(5, 3, 7) == asked.poses[::3][:, None]).all()
    assert len(np.unique(asked.start, axis=0)) == 15
    assert arm.within_limits(asked.start).all()


def test_starts(arm: Robot) -> None:
    assert (ask(arm, start="home") == arm.home).all()
    assert (ask(arm, start="middle") == (arm.lower + arm.upper) / 2).all()
    assert questions(arm, protocol(start="none"), 0, False).start is None


def test_targets_near_home_are_within_their_angles() -> None:
    arm = load_robot("panda")  # of all targets the first and every second is the nearer kind
    rules = protocol(targets="near_home", within_deg=[3.0, 10.0], most_poses=100)
    poses = questions(arm, rules, 0, False).poses
    assert len(poses) == 100
    home = arm.forward_kinematics(arm.home)[0, :3]
    distance = np.linalg.norm(poses[:, :3] - home, axis=1)
    assert 0 < distance[::2].mean() < 0.5 * distance[1::2].mean()
    # 3 deg of seven joints, none of which is further from the tip than the arm is long
    assert distance[::2].max() < 7 * np.deg2rad(3.0) * 1.3


def test_targets_do_not_depend_on_their_number_or_the_solver(arm: Robot) -> None:
    for targets in ("halton", "uniform", "free", "workspace"):
        few, many = (
            questions(arm, protocol(targets=targets, most_poses=n), 0, False).poses for n in (5, 9)
        )
        assert (few == many[:5]).all(), targets
    other = questions(arm, protocol(most_poses=5), 1, False).poses
    assert (other != questions(arm, protocol(most_poses=5), 0, False).poses).any()


def test_errors_along_axes_are_those_of_the_target() -> None:
    turn = quaternion_from_rotation_vector(np.array([[0.0, 0.0, np.pi / 2]]))
    target = np.hstack([[[0.3, 0.0, 0.5]], turn])
    small = quaternion_from_rotation_vector(np.array([[0.01, -0.02, 0.0]]))
    reached = np.hstack([[[0.301, -0.002, 0.5]], quaternion_multiply(turn, small)])
    position, rotation = axis_errors(target, reached)
    assert position == pytest.approx([2.0])
    assert rotation == pytest.approx([np.rad2deg(0.02)])
    skew = quaternion_from_rotation_vector(np.array([[0.0, 0.0, np.pi / 4]]))
    target = np.hstack([[[0.0, 0.0, 0.0]], skew])
    reached = np.hstack([[[0.001, 0.001, 0.0]], skew])  # along the target's own x
    assert axis_errors(target, reached)[0] == pytest.approx([np.sqrt(2.0)])


def test_rows_say_target_and_call(arm: Robot) -> None:
    rules = protocol(most_poses=3, draws=2, batch_sizes=[4], start="random")
    asked = questions(arm, rules, 0, False)
    rows = pd.DataFrame({"pose": np.arange(6), "batch_size": 4, "q0": 0.1, "q1": 0.2})
    made = with_protocol(rows, asked, arm, rules)
    assert made.target.tolist() == [0, 0, 1, 1, 2, 2]
    assert made.call.tolist() == [0, 0, 0, 0, 1, 1]
    here = arm.forward_kinematics(np.array([[0.1, 0.2]]))
    expected, _ = axis_errors(asked.poses, np.repeat(here, 6, axis=0))
    assert made.axis_position_error_mm.to_numpy() == pytest.approx(expected)
