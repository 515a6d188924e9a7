"""Errors of a real arm: zeros that are off, play, objects that weigh something else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from baselines import load
from pipeline.config import compose
from pipeline.errors import ConfigError
from pipeline.grasping.config import HardwareConfig
from pipeline.grasping.hardware import Hardware
from pipeline.grasping.scene import Scene
from pipeline.grasping.trial import run_trial
from robots import Robot, load_robot

GRASP = compose(["profile=smoke", "grasp.video=none"]).grasp
NONE = HardwareConfig(zero_offset=0.0, backlash=0.0, mass_spread=0.0)


@pytest.fixture(scope="module")
def nico() -> Robot:
    return load_robot("nico")


def with_play(play: float) -> Hardware:
    return replace(Hardware.perfect(1), backlash=np.array([play]))


def test_play_is_crossed_before_a_link_follows() -> None:
    """A gap of 0.2 rad by hand: up to 1.0, back to 0.9 and 0.7, up again."""
    joint, links = with_play(0.2), []
    for motor in (0.0, 0.05, 1.0, 0.9, 0.7, 0.75, 1.0):
        links.append(joint.follow(np.array([motor]), None)[0][0])
    assert links == pytest.approx([0.0, 0.0, 0.9, 0.9, 0.8, 0.8, 0.9])


def test_a_link_within_the_play_is_not_asked_to_move() -> None:
    joint, fast = with_play(0.2), np.array([3.0])
    joint.follow(np.array([0.0]), fast)
    _, still = joint.follow(np.array([0.05]), fast)
    _, drawn = joint.follow(np.array([0.5]), fast)
    assert (still, drawn) == (np.array([0.0]), np.array([3.0]))


def test_play_never_exceeds_half_its_width() -> None:
    joint, draw = with_play(0.3), np.random.default_rng(0)
    motors = np.cumsum(draw.normal(0.0, 0.2, 500))
    away = [joint.follow(np.array([m]), None)[0][0] - m for m in motors]
    assert np.abs(away).max() == pytest.approx(0.15)
    assert np.abs(away).min() < 0.15 - 1e-3


def test_without_errors_every_bit_stays(nico: Robot) -> None:
    perfect = Hardware.drawn(NONE, nico, 0, 0)
    joints, velocities = nico.sample(1, seed=1)[0], np.linspace(-1.0, 1.0, nico.dof)
    sent, fast = perfect.follow(joints, velocities)
    assert np.array_equal(sent, joints)
    assert fast is velocities
    assert perfect.weigh(0.349) == 0.349


def test_zeros_are_normal_and_a_trial_s_own(nico: Robot) -> None:
    config = replace(NONE, zero_offset=0.02)
    drawn = np.array([Hardware.drawn(config, nico, 0, number).offset for number in range(400)])
    assert drawn.std() == pytest.approx(0.02, rel=0.05)
    assert abs(drawn.mean()) < 0.002
    assert np.array_equal(drawn[7], Hardware.drawn(config, nico, 0, 7).offset)
    twice = Hardware.drawn(replace(NONE, zero_offset=0.04), nico, 0, 7).offset
    assert twice == pytest.approx(2.0 * drawn[7])


def test_masses_spread_about_what_is_stated(nico: Robot) -> None:
    weighing = Hardware.drawn(replace(NONE, mass_spread=0.5), nico, 0, 0)
    logs = np.log([weighing.weigh(2.0) / 2.0 for _ in range(2000)])
    assert logs.std() == pytest.approx(0.5, rel=0.05)
    assert abs(logs.mean()) < 0.05


def test_sliding_joints_have_no_such_errors() -> None:
    fetch = load_robot("fetch")
    sliding = fetch.chain.variable[fetch.chain.prismatic]
    assert len(sliding)
    drawn = Hardware.drawn(replace(NONE, zero_offset=0.1, backlash=0.1), fetch, 0, 0)
    assert not drawn.offset[sliding].any()
    assert not drawn.backlash[sliding].any()
    assert np.count_nonzero(drawn.backlash) == fetch.dof - len(sliding)


def test_the_arm_of_the_simulator_goes_where_its_zeros_say(nico: Robot) -> None:
    config = replace(NONE, zero_offset=0.03)
    hardware = Hardware.drawn(config, nico, 3, 0)
    with Scene(nico, GRASP.scenes["nico"], GRASP.physics, hardware=hardware) as scene:
        scene.wait(1.0)
        there = scene.joints()
    expected = np.clip(nico.home + hardware.offset, nico.lower, nico.upper)  # a stop is a stop
    assert there == pytest.approx(expected, abs=5e-3)


def test_an_object_weighs_what_was_drawn(nico: Robot) -> None:
    hardware = Hardware.drawn(replace(NONE, mass_spread=0.5), nico, 0, 4)
    expected = Hardware.drawn(replace(NONE, mass_spread=0.5), nico, 0, 4).weigh(0.015)
    obj = replace(GRASP.objects[GRASP.scenes["nico"].objects[0]], mass=0.015)
    with Scene(nico, GRASP.scenes["nico"], GRASP.physics, hardware=hardware) as scene:
        body = scene.lay(obj, (0.3, -0.1), 0.0)
        weighed = scene.client.getDynamicsInfo(body, -1)[0]
    assert weighed == pytest.approx(expected)


def test_a_trial_names_its_errors(nico: Robot) -> None:
    config = replace(GRASP, hardware=replace(NONE, zero_offset=np.deg2rad(40.0)))
    row = run_trial(config, nico, load("lm", nico), 0, 0)
    assert row["zero_offset_deg"] == pytest.approx(40.0)
    assert row["class"] == "Not Grasped"
    assert row["tracking_error_mm"] > 50


@pytest.mark.parametrize("key", ["zero_offset", "backlash", "mass_spread"])
def test_negative_errors_are_refused(key: str) -> None:
    with pytest.raises(ConfigError, match=f"grasp.hardware.{key}"):
        compose([f"grasp.hardware.{key}=-1"])
