"""What each suite promises of its poses, and the checksums that tie a version to its content."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import baselines
from baselines import registry
from baselines.freedom import nearest_allowed, widths_of
from baselines.registry import using
from pipeline.config import group_choices
from pipeline.suites.config import CLASSES
from pipeline.suites.drawing import SuiteError
from pipeline.suites.generators import (
    GENERATORS,
    Suite,
    generate,
    read_suite,
    write_suite,
)
from pipeline.suites.problems import checksum, freedoms, from_frame, to_frame
from pipeline.suites.singularity import scale, smallest_singular_value
from robots import Robot, load_robot
from robots.rotations import matrix_from_quaternion, rotation_angle
from tests.suites import POSES, config_of, known_checksums

FIXTURES = Path(__file__).parents[2] / "fixtures"
ROBOTS = ("panda", "mixed")  # all others: tests/slow/test_all_suites.py
SUITES = group_choices("suite")


@cache
def robot_of(name: str) -> Robot:
    mixed = {"urdf": FIXTURES / "mixed.urdf", "tip": "tool"}
    return load_robot(**mixed) if name == "mixed" else load_robot(name)


@cache
def suite_of(robot: str, suite: str) -> Suite:
    return generate(robot_of(robot), config_of(suite), 0)


def test_every_suite_has_a_generator_and_a_class() -> None:
    assert {config_of(name).generator for name in SUITES} == {*GENERATORS} == {*CLASSES}


@pytest.mark.parametrize("suite", SUITES)
@pytest.mark.parametrize("robot", ROBOTS)
def test_a_version_has_the_content_that_it_had(robot: str, suite: str) -> None:
    """Where this fails the generator has changed: raise `version` and add the new checksum."""
    made = suite_of(robot, suite)
    assert known_checksums(robot, suite, made.version) == [made.checksum]


@pytest.mark.parametrize("suite", SUITES)
def test_another_generation_gives_the_same_and_another_seed_does_not(suite: str) -> None:
    again = generate(load_robot(urdf=FIXTURES / "mixed.urdf", tip="tool"), config_of(suite), 0)
    assert again.checksum == suite_of("mixed", suite).checksum
    assert generate(robot_of("mixed"), config_of(suite), 1).checksum != again.checksum


@pytest.mark.parametrize("suite", SUITES)
def test_a_small_suite_is_the_beginning_of_a_larger(suite: str) -> None:
    config = config_of(suite)
    small = generate(robot_of("mixed"), replace(config, poses=8, trajectories=1), 0).problems
    large = suite_of("mixed", suite).problems
    np.testing.assert_array_equal(small.poses, large.poses[: len(small)])
    np.testing.assert_array_equal(small.stratum, large.stratum[: len(small)])
    if suite != "tracking":
        assert len(generate(robot_of("mixed"), replace(config, poses=1), 0).problems) == 1


@pytest.mark.parametrize("suite", [name for name in SUITES if name != "unreachable"])
@pytest.mark.parametrize("robot", ROBOTS)
def test_a_known_configuration_solves_its_pose(robot: str, suite: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, suite).problems
    assert made.within_limits(problems.joints).all()
    assert not made.in_collision(problems.joints).any()
    reached = made.forward_kinematics(problems.joints)
    allowed, left_open = problems.poses, freedoms(problems)
    if left_open is not None:
        widths = widths_of(left_open, len(problems))
        allowed = nearest_allowed(allowed, reached, widths)
    np.testing.assert_allclose(reached, allowed, atol=1e-8)
    if suite != "tracking":
        assert len(problems) == POSES


@pytest.mark.parametrize("robot", ROBOTS)
def test_two_joints_or_more_are_at_their_limits(robot: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, "at_limits").problems
    width = made.upper - made.lower
    distance = np.minimum(problems.joints - made.lower, made.upper - problems.joints) / width
    near = ((distance <= 0.01 + 1e-8) & ~made.endless).sum(axis=1)
    wanted = np.array([int(name.split()[0]) for name in problems.stratum])
    assert (wanted >= 2).all()
    assert (near >= wanted).all()


def test_a_robot_without_limits_has_no_such_poses(tmp_path: Path) -> None:
    text = (FIXTURES / "two_link.urdf").read_text(encoding="utf-8")
    path = tmp_path / "endless.urdf"
    path.write_text(text.replace('type="revolute"', 'type="continuous"'), encoding="utf-8")
    with pytest.raises(SuiteError, match=r"two joints with limits, 'two_link.*' has 0"):
        generate(load_robot(urdf=path), config_of("at_limits"), 0)


@pytest.mark.parametrize("robot", ROBOTS)
def test_near_singular_is_the_lowest_share_of_an_independent_sample(robot: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, "near_singular").problems
    length_m = scale(made)[1]
    sample = smallest_singular_value(made, made.sample(5000, seed=77), length_m)
    mine = smallest_singular_value(made, problems.joints, length_m)
    assert np.mean(sample <= mine.max()) < 0.03


@pytest.mark.parametrize("robot", ROBOTS)
def test_the_boundary_is_where_almost_no_sample_is(robot: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, "boundary").problems
    bound = scale(made)[0]
    points = made.forward_kinematics(made.sample(5000, seed=78))[:, :3]
    usual = np.linalg.norm(points - bound.nearest(points), axis=1)
    places = problems.poses[:, :3]
    distance = np.linalg.norm(places - bound.nearest(places), axis=1)
    assert distance.max() <= bound.radius_m
    assert distance.min() > 0.95 * bound.radius_m
    assert np.mean(usual > distance.min()) < 0.05


@pytest.mark.parametrize("robot", ROBOTS)
def test_what_is_out_of_reach_is_and_no_solver_of_ours_claims_it(robot: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, "unreachable").problems
    bound = scale(made)[0]
    assert set(problems.stratum[:4]) == {
        "beyond_1mm",
        "beyond_10mm",
        "beyond_100mm",
        "orientation",
    }
    assert np.isnan(problems.joints).all()
    places = problems.poses[:, :3]
    distance = np.linalg.norm(places - bound.nearest(places), axis=1)
    for margin in (1, 10, 100):
        mine = problems.stratum == f"beyond_{margin}mm"
        np.testing.assert_allclose(distance[mine], bound.radius_m + margin / 1e3, atol=1e-7)
    turned = problems.stratum == "orientation"
    assert (distance[turned] <= bound.radius_m).all()
    assert (problems.further["evidence_starts"][turned] == 1000).all()
    place = np.stack(
        [problems.further[f"evidence_place_q{joint}"][turned] for joint in range(made.dof)], axis=1
    )
    reached = made.forward_kinematics(place)[:, :3]
    np.testing.assert_allclose(reached, places[turned], atol=1e-8)
    solver = baselines.load("lm", made, iterations=2000)
    assert not solver.solve(problems.poses).found.any()


@pytest.mark.parametrize("robot", ROBOTS)
def test_what_is_free_is_turned_and_nothing_else(robot: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, "partial").problems
    assert problems.stratum[:4].tolist() == ["position", "axis z"] * 2
    reached = made.forward_kinematics(problems.joints)
    np.testing.assert_allclose(reached[:, :3], problems.poses[:, :3], atol=1e-8)
    turned = rotation_angle(reached[:, 3:], problems.poses[:, 3:])
    assert np.median(turned) > 0.7  # rad; a solver of whole poses has another task
    axis = problems.stratum == "axis z"
    mine, theirs = (
        matrix_from_quaternion(poses[axis, 3:])[:, :, 2] for poses in (reached, problems.poses)
    )
    np.testing.assert_allclose(mine, theirs, atol=1e-7)


@pytest.mark.parametrize("robot", ROBOTS)
def test_warm_targets_are_so_far_from_their_start(robot: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, "warm").problems
    assert problems.start is not None
    unit = np.where(made.sliding, scale(made)[1], 1.0)  # a sliding joint: 1 rad by its length
    moved = np.rad2deg(np.abs(problems.joints - problems.start) / unit)
    for name, degrees in (("3deg", 3.0), ("10deg", 10.0)):
        np.testing.assert_allclose(moved[problems.stratum == name], degrees, atol=1e-6)
    assert not made.in_collision(problems.start).any()


@pytest.mark.parametrize("robot", ROBOTS)
def test_a_trajectory_can_be_followed_within_the_speed_of_every_joint(robot: str) -> None:
    made, problems = robot_of(robot), suite_of(robot, "tracking").problems
    limits = made.velocity_limit
    limits = np.where(np.isfinite(limits), limits, 1.0)
    rate, step = problems.further["rate_hz"], problems.further["step"]
    speed = np.abs(np.diff(problems.joints, axis=0)) * rate[1:, None]
    within = speed[step[1:] > 0]
    assert (within <= 0.5 * limits * 1.001 + 1e-5).all()
    first = step == 0
    assert first.sum() == 2 * 2
    assert problems.start is not None
    np.testing.assert_array_equal(problems.start[first], problems.joints[first])
    assert np.isnan(problems.start[~first]).all()
    middle = smallest_singular_value(
        made, problems.joints[problems.stratum == "singular"], scale(made)[1]
    )
    sample = smallest_singular_value(made, made.sample(5000, seed=79), scale(made)[1])
    assert np.mean(sample <= middle.min()) < 0.03


def test_fast_joints_with_narrow_ranges_are_followed_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = (FIXTURES / "two_link.urdf").read_text(encoding="utf-8")
    path = tmp_path / "fast.urdf"
    path.write_text(re.sub(r'velocity="[^"]*"', 'velocity="900"', text), encoding="utf-8")
    monkeypatch.setattr("pipeline.suites.tracking.PATIENCE", 1)
    problems = generate(load_robot(urdf=path), config_of("tracking"), 0).problems
    assert load_robot(urdf=path).within_limits(problems.joints).all()
    assert len(set(problems.further["trajectory"])) == 2


def test_a_file_holds_the_suite_and_no_other(tmp_path: Path) -> None:
    robot, config = robot_of("mixed"), config_of("unreachable")
    path = tmp_path / "suite.parquet"
    made = write_suite(path, robot, config, 0, {})
    found = read_suite(path, robot, config, 0)
    assert found.checksum == made.checksum == suite_of("mixed", "unreachable").checksum
    pd.testing.assert_frame_equal(
        to_frame(found.problems, robot), to_frame(made.problems, robot), check_dtype=False
    )
    with pytest.raises(SuiteError, match=r"other values of suite.poses; make it again"):
        read_suite(path, robot, replace(config, poses=41), 0)
    with pytest.raises(SuiteError, match=r"suite.version"):
        read_suite(path, robot, replace(config, version=2), 0)
    with pytest.raises(SuiteError, match="robot, robot_checksum"):
        read_suite(path, robot_of("panda"), config, 0)
    path.write_bytes(path.read_bytes()[:-50])
    with pytest.raises(
        SuiteError, match=r"not a readable Parquet file.*pipeline suite robot=mixed"
    ):
        read_suite(path, robot, config, 0)


def test_settings_of_a_run_do_not_change_what_cannot_be_reached() -> None:
    with using({"lm": {**registry.file_settings("lm"), "patience": 1, "damping_gain": 10.0}}):
        made = generate(robot_of("panda"), config_of("unreachable"), 0)
    assert made.checksum == suite_of("panda", "unreachable").checksum


def test_evidence_is_not_part_of_the_checksum_and_all_else_is() -> None:
    frame = to_frame(suite_of("mixed", "unreachable").problems, robot_of("mixed"))
    whole = checksum(frame)
    assert checksum(frame.assign(evidence_starts=7.0)) == whole
    for name in ("qz", "stratum"):
        assert checksum(frame.assign(**{name: frame[name].to_numpy()[::-1]})) != whole, name
    assert checksum(frame.assign(x=frame.x + 1e-9)) != whole
    assert from_frame(frame, robot_of("mixed")).start is None
