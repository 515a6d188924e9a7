"""Pushing and pointing in the simulator: what they do, and how they fail."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import baselines
from pipeline.config import compose
from pipeline.embodiment.body import Body
from pipeline.embodiment.row import row_setup
from pipeline.embodiment.scene_objects import SceneObjects
from pipeline.grasping.point import distance_to_line
from pipeline.grasping.scene import Scene
from pipeline.grasping.trial import required_scene
from robots import load_robot
from tests.physics_guard import guard

CONFIG = compose(["profile=smoke"]).grasp
TARGETS = {"panda": "pear", "nico": "grapes", "nicol": "orange"}


@pytest.fixture(scope="module", params=list(TARGETS))
def each(request):
    robot = load_robot(request.param)
    return robot, baselines.load("lm", robot)


def act(each, kind, row=3, away=0.0, **changes):
    """One action on an object of a row; its result, how far everything moved [m], which it was."""
    robot, solver = each
    config = replace(required_scene(CONFIG, robot.name), **changes)
    with Scene(robot, config, CONFIG.physics) as scene:
        objects = SceneObjects(scene, CONFIG, row_setup(CONFIG, robot.name, row, seed=0))
        scene.wait(CONFIG.physics.settle_s)
        before = {obj.name: objects.position(obj) for obj in objects.all}
        target = objects.named(TARGETS[robot.name])
        place = objects.position(target) + np.array([away, 0.0, 0.0])
        body = Body(scene, CONFIG, solver, solver)
        result = body.act(kind, place, target.name, target.body)
        moved = {t.name: np.linalg.norm(objects.position(t) - before[t.name]) for t in objects.all}
        assert np.abs(scene.joints() - robot.home).max() < 0.05, "the arm is back at idle"
    return result, moved, target.name


def test_pushing_moves_the_object_and_no_other(each, monkeypatch):
    guard(monkeypatch)
    # In a row whose objects stand apart: beside a neighbour, Panda's wide gripper sweeps it along.
    result, moved, name = act(each, "push", row=4)
    assert result.done, result.words
    assert moved.pop(name) > 0.02
    assert max(moved.values()) < 0.005


def test_pointing_moves_nothing(each, monkeypatch):
    guard(monkeypatch)
    result, moved, _ = act(each, "point")
    assert result.done, result.words
    assert max(moved.values()) < 0.005


@pytest.mark.parametrize("kind", ["push", "point", "grasp"])
def test_what_is_out_of_reach_is_a_deed_with_a_reason(each, kind):
    result, _, _ = act(each, kind, away=1.5)
    assert not result.done
    assert "out of reach" in result.words


def test_pushing_or_pointing_beside_an_object_is_a_failure():
    robot = load_robot("panda")
    panda = robot, baselines.load("lm", robot)
    result, _, _ = act(panda, "point", away=0.09)
    assert (result.done, "beside" in result.words) == (False, True)
    result, _, _ = act(panda, "push", away=-0.25)
    assert (result.done, "moved 0 mm" in result.words) == (False, True)


def test_the_distance_of_an_object_from_a_finger_s_line():
    origin, ahead = np.zeros(3), np.array([1.0, 0.0, 0.0])
    assert np.isclose(distance_to_line(np.array([2.0, 0.3, 0.4]), origin, ahead), 0.5)
    assert np.isclose(distance_to_line(np.array([-3.0, 0.0, 4.0]), origin, ahead), 5.0)
