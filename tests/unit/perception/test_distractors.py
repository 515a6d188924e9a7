"""Distractors: where they lie, that nothing touches them, and that they come once a scene."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

from pipeline.config import compose
from pipeline.embodiment.senses import Eyes
from pipeline.perception.camera import EyeCamera
from pipeline.perception.detection import Detection
from pipeline.perception.distractors import BEYOND, CLEAR, lay_distractors
from pipeline.perception.studio import Studio

CONFIG = compose(["perception=camera"])


def places_of(client: Any, bodies: list[int]) -> np.ndarray:
    return np.array([client.getBasePositionAndOrientation(body)[0] for body in bodies])


def test_they_lie_on_the_table_clear_of_the_things_and_collide_with_nothing(studio: Studio) -> None:
    client, scene = studio.scene.client, studio.scene.config
    middle = (float(np.mean(scene.area.x)), float(np.mean(scene.area.y)))
    bodies = lay_distractors(client, scene, 5, np.random.default_rng(0), [middle])
    try:
        places = places_of(client, bodies)
        assert len(places) == 5
        assert (np.linalg.norm(places[:, :2] - middle, axis=1) >= CLEAR).all()
        assert (places[:, 2] > scene.table.height).all()
        assert (places[:, 2] < scene.table.height + 0.03).all()
        low, high = np.transpose([scene.area.x, scene.area.y])
        assert ((places[:, :2] > low - BEYOND) & (places[:, :2] < high + BEYOND)).all()
        for body in bodies:
            assert not client.getCollisionShapeData(body, -1)
            assert client.getVisualShapeData(body)
    finally:
        for body in bodies:
            client.removeBody(body)


def test_where_there_is_no_room_there_are_none(studio: Studio) -> None:
    scene = studio.scene.config
    grid = [(x, y) for x in np.arange(0.0, 1.0, 0.05) for y in np.arange(-1.0, 0.6, 0.05)]
    assert lay_distractors(studio.scene.client, scene, 3, np.random.default_rng(0), grid) == []


def test_eyes_see_them_from_their_first_look_at_a_scene_on(studio: Studio) -> None:
    client, scene = studio.scene.client, studio.scene.config
    wrong = replace(CONFIG.perception.perturbation, distractors=4)
    camera = EyeCamera(studio.scene.robot, CONFIG.perception.eye, wrong)
    seen: list[np.ndarray] = []

    class Blind:
        names = tuple(scene.objects)

        def detect(self, image: np.ndarray) -> list[Detection]:
            seen.append(image)
            return []

    eyes = Eyes(camera, Blind(), {}, 0.0)
    things: Any = SimpleNamespace(all=[0], position=lambda _: np.array([0.3, -0.1, 0.6]))
    plain, before = camera.picture(client), client.getNumBodies()
    eyes.look(studio.scene, things)
    eyes.look(studio.scene, things)
    added = [client.getBodyUniqueId(i) for i in range(before, client.getNumBodies())]
    try:
        assert len(added) == 4
        assert (seen[0] == seen[1]).all() and (seen[0] != plain).any()
        first = places_of(client, added)
    finally:
        for body in added:
            client.removeBody(body)
    again = camera.distract(client, scene, [(0.3, -0.1)])
    assert (places_of(client, again) == first).all()  # the things' places fix them
    for body in again:
        client.removeBody(body)
