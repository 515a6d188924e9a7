"""The detectors that come with the project: small, as good as their card says, and of use."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.perception.camera import EyeCamera
from pipeline.perception.embedded import EmbeddedDetector
from pipeline.perception.layout import Laid
from pipeline.perception.loading import load_detector, see
from pipeline.perception.studio import Studio
from pipeline.perception.weights import (
    LARGEST_BYTES,
    WEIGHTS,
    load_centre_network,
    read_detector_card,
    shipped_detector,
)
from robots import load_robot

CONFIG = compose(["perception=camera"])
NAMES = ("nico", "nicol")
WITHIN = 0.02  # m


@pytest.mark.parametrize("name", NAMES)
def test_they_are_small_and_their_card_tells_what_they_reach(name: str) -> None:
    folder = shipped_detector(name)
    assert (folder / WEIGHTS).stat().st_size <= LARGEST_BYTES
    card = read_detector_card(folder, name)
    assert card["names"] == list(CONFIG.grasp.scenes[name].objects)
    quality = card["held_out"]
    assert quality["pictures"] == 500
    assert quality["map50"] >= 0.97
    assert quality["position_error_mm"] <= 8.0
    assert quality["position_error_p95_mm"] <= 20.0


@pytest.mark.parametrize("name", NAMES)
def test_they_find_every_object_of_a_fixed_scene_within_two_centimetres(name: str) -> None:
    robot, scene = load_robot(name), CONFIG.grasp.scenes[name]
    detector = load_detector(CONFIG.perception, robot, scene.objects)
    camera = EyeCamera(robot, CONFIG.perception.eye, CONFIG.perception.perturbation)
    heights = {
        each: scene.table.height + 0.5 * CONFIG.grasp.objects[each].height for each in scene.objects
    }
    share = (np.arange(len(scene.objects)) + 0.5) / len(scene.objects)
    across = scene.area.y[0] + share * (scene.area.y[1] - scene.area.y[0])
    with Studio(robot, CONFIG.grasp, CONFIG.perception.eye, 0.5) as studio:
        for x, turn in product(scene.area.x, range(2)):
            names = np.roll(scene.objects, turn)
            laid = [Laid(str(n), (x, y), 0.7 + x) for n, y in zip(names, across, strict=True)]
            image = studio.photograph(laid, camera.actual, camera.config).image
            seen = see(image, detector, camera, heights)
            assert sorted(each.name for each in seen) == sorted(scene.objects)
            for each in laid:
                (sighting,) = (one for one in seen if one.name == each.name)
                assert np.hypot(*(sighting.position[:2] - each.place)) < WITHIN, each


@pytest.mark.parametrize("name", NAMES)
def test_held_out_pictures_are_read_as_well_as_the_card_says(name: str) -> None:
    """A few pictures anew, at the size of the eye's, with other seeds than the card's."""
    robot, domain = load_robot(name), CONFIG.detector.held_out
    detector = EmbeddedDetector(
        load_centre_network(shipped_detector(name), name), CONFIG.perception
    )
    errors, objects = [], 0
    with Studio(robot, CONFIG.grasp, CONFIG.perception.eye, CONFIG.detector.visible) as studio:
        for seed in range(12):
            shot = studio.shoot(np.random.default_rng([99, seed]), domain, (640, 480))
            found = {each.name: each for each in detector.detect(shot.image)}
            objects += len(shot.labels)
            for label in shot.labels:
                if label.name in found:
                    pixel = found[label.name].centroid
                    place = shot.camera.project([pixel], label.position[2])[0]
                    errors.append(np.hypot(*(place - label.position)[:2]))
    assert len(errors) >= 0.9 * objects
    assert np.median(errors) < 0.008


def test_they_are_refused_for_other_objects() -> None:
    with pytest.raises(ValueError, match="expected banana"):
        load_detector(CONFIG.perception, load_robot("nico"), ["banana"])
