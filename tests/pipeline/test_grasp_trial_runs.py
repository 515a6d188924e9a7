"""Whole trials in the simulator: what is held is held by physics, and failures have reasons."""

import json
from dataclasses import replace

import pybullet
import pytest

import baselines
from pipeline.config import compose
from pipeline.grasping import scene as scene_module
from pipeline.grasping.outcome import NOT_GRASPED, SLIPPED, SUCCESS
from pipeline.grasping.trial import run_trial
from robots import load_robot
from tests.physics_guard import guard

CONFIG = compose(["profile=smoke", "experiment=refined_grasp"]).grasp
PAPER = compose(["profile=smoke"]).grasp  # one motion lifts and deposits, and nobody looks
MOTIONS = ("approach", "lift", "transfer", "deposit", "homeward")
TIMES = ("wall_s", *(f"{name}_plan_ms" for name in MOTIONS))


@pytest.fixture(scope="module")
def panda():
    robot = load_robot("panda")
    return robot, baselines.load("lm", robot)


@pytest.fixture(scope="module", params=["panda", "nico", "nicol"])
def each(request):
    robot = load_robot(request.param)
    return robot, baselines.load("lm", robot)


def changed(scene=None, **values):
    scenes = dict(CONFIG.scenes)
    if scene is not None:
        scenes["panda"] = scene
    return replace(CONFIG, scenes=scenes, **values)


def test_panda_succeeds_and_does_the_same_again(panda):
    first, again = (run_trial(CONFIG, *panda, number=1, seed=0) for _ in range(2))
    assert first["class"] == SUCCESS
    assert first["contacts_lifted"] >= 2
    assert first["approach_tip_error_mm"] < 1.0
    assert {k: v for k, v in first.items() if k not in TIMES} == {
        k: v for k, v in again.items() if k not in TIMES
    }


def test_nothing_is_glued_or_put_anywhere_once_the_world_runs(each, monkeypatch):
    running = guard(monkeypatch)
    row = run_trial(CONFIG, *each, number=1, seed=0)
    assert row["class"] == SUCCESS, row["reason"]
    assert row["contacts_lifted"] >= 2
    assert len(running) > 1000


def test_one_motion_lifts_and_deposits(each):
    row = run_trial(PAPER, *each, number=1, seed=0)
    assert row["class"] == SUCCESS, row["reason"]
    assert row["lifted"]
    assert row["contacts_lifted"] >= 2
    assert row["deposit_plan_ms"] > 0
    assert row["swung"] == ""
    assert (row["lift_flips"], row["transfer_flips"]) == (-1, -1), "motions that were not made"


def test_one_motion_without_anything_in_the_hand_goes_on(panda):
    scene = PAPER.scenes["panda"]
    weak = replace(scene, hand=replace(scene.hand, tension=0.0))
    row = run_trial(replace(PAPER, scenes={**PAPER.scenes, "panda": weak}), *panda, 1, 0)
    assert (row["class"], row["reason"]) == (NOT_GRASPED, "the hand did not close")
    assert row["deposit_plan_ms"] > 0


def test_the_wrapper_would_notice(panda, monkeypatch):
    def glue(*_, **__):
        raise AssertionError("createConstraint was called")

    monkeypatch.setattr(pybullet, "createConstraint", glue)
    robot, _ = panda
    with (
        scene_module.Scene(robot, CONFIG.scenes["panda"], CONFIG.physics) as scene,
        pytest.raises(AssertionError, match="createConstraint"),
    ):
        scene.client.createConstraint()


def test_a_hand_that_never_closes_is_not_grasped(panda):
    scene = CONFIG.scenes["panda"]
    config = changed(replace(scene, hand=replace(scene.hand, tension=0.0)))
    row = run_trial(config, *panda, number=1, seed=0)
    assert row["class"] == NOT_GRASPED
    assert row["reason"] == "the hand did not close"
    json.dumps(row)  # rows of trials are kept as JSON lines, so nothing in them may be NumPy's


def test_an_object_out_of_reach_is_not_grasped(panda):
    scene = CONFIG.scenes["panda"]
    far = replace(scene, area=replace(scene.area, x=[1.4, 1.6]))
    row = run_trial(changed(far), *panda, number=0, seed=0)
    assert row["class"] == NOT_GRASPED
    assert "out of reach" in row["reason"]


def test_a_missing_bin_is_a_class_with_a_reason(panda):
    scene = CONFIG.scenes["panda"]
    row = run_trial(changed(replace(scene, bins={})), *panda, number=1, seed=0)
    assert row["class"] == SLIPPED
    assert "there is no right bin" in row["reason"]


def test_an_object_that_falls_off_before_it_is_reached_is_not_grasped(panda):
    scene = CONFIG.scenes["panda"]
    elsewhere = replace(scene, table=replace(scene.table, size=[0.1, 0.1, 0.04], centre=[0.0, 0.9]))
    row = run_trial(changed(elsewhere), *panda, number=1, seed=0)
    assert row["class"] == NOT_GRASPED


def test_a_large_error_of_the_place_misses(panda):
    row = run_trial(changed(position_error=0.12), *panda, number=1, seed=0)
    assert row["class"] == NOT_GRASPED


def test_an_object_that_rolls_away_is_not_grasped(panda, monkeypatch):
    step = scene_module.Scene.step

    def breeze(self):
        if 0.5 < self.time_s < 0.8:  # after the object's place was read
            at = self.object_position().tolist()
            self.client.applyExternalForce(
                self.object_id, -1, [0, 0.15, 0], at, pybullet.WORLD_FRAME
            )
        step(self)

    monkeypatch.setattr(scene_module.Scene, "step", breeze)
    row = run_trial(CONFIG, *panda, number=1, seed=0)
    assert row["object"] == "baseball"
    assert row["class"] == NOT_GRASPED
    assert "before the fingers closed" in row["reason"]
