"""Distractors: where they lie, that nothing touches them, and that a draw fixes them."""

from __future__ import annotations

from typing import Any

import numpy as np

from pipeline.config import compose
from pipeline.perception.camera import EyeCamera
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


def test_the_same_draw_lays_the_same_ones_and_the_camera_sees_them(studio: Studio) -> None:
    client, scene = studio.scene.client, studio.scene.config
    camera = EyeCamera(studio.scene.robot, CONFIG.perception.eye)
    plain, places, pictures = camera.picture(client), [], []
    for _ in range(2):
        bodies = lay_distractors(client, scene, 4, np.random.default_rng(7))
        places.append(places_of(client, bodies))
        pictures.append(camera.picture(client))
        for body in bodies:
            client.removeBody(body)
    assert (places[0] == places[1]).all() and len(places[0]) == 4
    assert (pictures[0] == pictures[1]).all() and (pictures[0] != plain).any()
