"""Labels of hand-placed objects, random layouts, and chunks that can be made again."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.perception.camera import mounted
from pipeline.perception.config import TEXTURES
from pipeline.perception.layout import Laid, footprint, lay_out, lit, moved
from pipeline.perception.pictures import Chunk, labels_path, render_chunk, render_pictures
from pipeline.perception.studio import Studio
from pipeline.perception.textures import pattern

CONFIG = compose(["perception=camera"])
EYE, DETECTOR = CONFIG.perception.eye, CONFIG.detector


def test_a_ball_is_labelled_where_it_lies(studio: Studio) -> None:
    """The box of a sphere is known: its silhouette is a disc about the projected centre, nearly."""
    scene = studio.scene.config
    ball = "tomato" if "tomato" in scene.objects else "orange"
    place = (float(np.mean(scene.area.x)), float(np.mean(scene.area.y)))
    camera = mounted(studio.scene.robot)
    (label,) = studio.photograph([Laid(ball, place, 0.0)], camera, EYE).labels
    obj = CONFIG.grasp.objects[ball]
    centre = np.array([*place, scene.table.height + 0.5 * obj.height])
    assert np.array(label.position) == pytest.approx(centre, abs=1e-3)
    assert np.array(label.centroid) == pytest.approx(camera.pixels_of(centre)[0], abs=0.6)
    x0, y0, x1, y1 = label.box
    assert [(x0 + x1) / 2, (y0 + y1) / 2] == pytest.approx(list(label.centroid), abs=2.0)
    distance = np.linalg.norm(centre - camera.pose[:3, 3])
    assert x1 - x0 == pytest.approx(camera.focal * obj.height / distance, rel=0.08)
    back = camera.project([label.centroid], label.position[2])[0]
    assert back == pytest.approx(centre, abs=1e-3)


def test_what_is_hidden_has_no_label(studio: Studio) -> None:
    """An object below the table's edge, out of the picture, is not labelled."""
    scene = studio.scene.config
    names = scene.objects[:2]
    seen = (float(np.mean(scene.area.x)), float(np.mean(scene.area.y)))
    laid = [Laid(names[0], seen, 0.0), Laid(names[1], (seen[0], seen[1] + 3.0), 0.0)]
    shot = studio.photograph(laid, mounted(studio.scene.robot), EYE)
    assert [label.name for label in shot.labels] == [names[0]]


def test_nothing_stays_from_one_picture_to_the_next(studio: Studio) -> None:
    bodies = studio.scene.client.getNumBodies()
    for _ in range(2):
        studio.shoot(np.random.default_rng(3), DETECTOR.training, (64, 48))
    assert studio.scene.client.getNumBodies() == bodies


def test_layouts_keep_to_the_table_and_off_the_bins(studio: Studio) -> None:
    scene, domain, objects = studio.scene.config, DETECTOR.training, CONFIG.grasp.objects
    low, high = np.transpose([scene.area.x, scene.area.y])
    count = 0
    for seed in range(40):
        laid = lay_out(np.random.default_rng(seed), domain, scene, objects)
        count += len(laid)
        assert len({each.name for each in laid}) == len(laid)
        for i, each in enumerate(laid):
            place = np.array(each.place)
            assert (place >= low - domain.reach).all() and (place <= high + domain.reach).all()
            for other in laid[:i]:
                least = footprint(objects[each.name]) + footprint(objects[other.name])
                assert np.hypot(*(place - other.place)) >= least
            for box in scene.bins.values():
                assert (np.abs(place - box.centre) > 0.5 * np.array(box.size[:2])).any()
    assert count > 0.7 * 40 * len(scene.objects)


def test_held_out_pictures_share_no_light_camera_or_colour_with_training() -> None:
    training, held_out = DETECTOR.training, DETECTOR.held_out
    for name in ("tilt", "shift", "hue"):
        assert getattr(training, name)[1] <= getattr(held_out, name)[0], name
    assert training.azimuth[1] <= held_out.azimuth[0]
    assert held_out.azimuth[1] <= training.azimuth[0] + 360.0
    assert not set(training.textures) & set(held_out.textures)


def test_cameras_and_lights_lie_within_their_domain(studio: Studio) -> None:
    camera, domain = mounted(studio.scene.robot), DETECTOR.held_out
    for seed in range(20):
        draw = np.random.default_rng(seed)
        other = moved(draw, domain, camera)
        turn = other.pose[:3, :3].T @ camera.pose[:3, :3]
        angle = np.rad2deg(np.arccos((np.trace(turn) - 1) / 2))
        assert domain.tilt[0] - 1e-6 <= angle <= domain.tilt[1] + 1e-6
        shift = np.linalg.norm(other.pose[:3, 3] - camera.pose[:3, 3])
        assert domain.shift[0] <= shift <= domain.shift[1]
        x, y, _ = lit(draw, domain, EYE).light
        assert domain.azimuth[0] <= np.rad2deg(np.arctan2(y, x)) % 360.0 <= domain.azimuth[1]


@pytest.mark.parametrize("kind", TEXTURES)
def test_patterns_have_the_size_of_their_points(kind: str) -> None:
    points = np.random.default_rng(0).uniform(0, 1, (7, 5, 2))
    values = pattern(np.random.default_rng(1), kind, points)
    assert values.shape == (7, 5)
    assert np.isfinite(values).all() and np.abs(values).max() <= np.sqrt(6.0)


def test_a_chunk_is_a_function_of_its_seed_and_is_made_once(tmp_path: Path) -> None:
    chunk = Chunk(
        robot="nico",
        grasp=CONFIG.grasp,
        eye=EYE,
        domain=DETECTOR.training,
        visible=DETECTOR.visible,
        size=(64, 48),
        first=0,
        count=3,
        seed=5,
        path=tmp_path / "a.npy",
    )
    render_chunk(chunk)
    render_chunk(replace(chunk, first=1, count=2, path=tmp_path / "b.npy"))
    whole, part = np.load(tmp_path / "a.npy"), np.load(tmp_path / "b.npy")
    assert (whole[1:] == part).all()  # whatever comes before a picture
    assert (whole[0] != whole[1]).any()
    made = chunk.path.stat().st_mtime_ns
    pictures = render_pictures([chunk], CONFIG.engine, "again")
    assert chunk.path.stat().st_mtime_ns == made  # what is there is taken, not rendered anew
    text = labels_path(chunk.path).read_text()
    labels_path(chunk.path).write_text(text.replace("tomato", "grapes"))
    again = render_pictures([chunk], CONFIG.engine, "again")
    assert chunk.path.stat().st_mtime_ns > made  # but not what was changed
    assert again.labels == pictures.labels
    assert len(pictures) == 3 and pictures.images[0].shape == (48, 64, 3)
