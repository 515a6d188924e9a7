"""The eyes: what is in view, what perturbations do, and what cannot be mounted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pipeline.config import compose
from pipeline.errors import PerceptionError
from pipeline.perception.camera import EyeCamera, dimmed, drawn_offset, mounted, take_picture
from pipeline.perception.config import PerturbationConfig
from pipeline.perception.layout import Laid
from pipeline.perception.studio import Studio
from robots import load_robot
from robots.description import read_description
from robots.errors import DescriptionError

CONFIG = compose(["perception=camera"])
EYE, NOTHING = CONFIG.perception.eye, CONFIG.perception.perturbation


def perturbed(**values: object) -> PerturbationConfig:
    return replace(NOTHING, **values)  # type: ignore[arg-type]


def test_everything_is_in_view_all_over_the_action_area(studio: Studio) -> None:
    """The idle arm hides nothing, and the picture's edge cuts nothing."""
    scene = studio.scene.config
    camera = mounted(studio.scene.robot)
    for name in scene.objects:
        for x in (scene.area.x[0], scene.area.x[1]):
            for y in (scene.area.y[0], sum(scene.area.y) / 2, scene.area.y[1]):
                (label,) = studio.photograph([Laid(name, (x, y), 0.5)], camera, EYE).labels
                x0, y0, x1, y1 = label.box
                assert x0 > 0 and y0 > 0 and x1 < camera.width and y1 < camera.height, name


@pytest.mark.parametrize("name", ["nico", "nicol"])
def test_pitch_moves_the_place_by_the_square_of_the_distance_over_the_height(name: str) -> None:
    robot = load_robot(name)
    scene = CONFIG.grasp.scenes[name]
    point = np.array([*np.mean([scene.area.x, scene.area.y], axis=1), scene.table.height + 0.02])
    camera = EyeCamera(robot, EYE, perturbed(tilt=[0.0, 0.25, 0.0]))
    pixel = camera.actual.pixels_of(point)
    moved = np.linalg.norm(camera.project(pixel, point[2])[0] - point)
    # A ray of length d that turns by a in its vertical plane sweeps a d / sin(depression) there.
    eye = camera.believed.pose[:3, 3]
    distance, drop = np.linalg.norm(point - eye), eye[2] - point[2]
    expected = np.deg2rad(0.25) * distance**2 / drop
    assert moved == pytest.approx(expected, rel=0.25)  # the tilt's axis is not quite level
    assert 0.0015 < moved < 0.006
    double = EyeCamera(robot, EYE, perturbed(tilt=[0.0, 0.5, 0.0]))
    twice = np.linalg.norm(double.project(double.actual.pixels_of(point), point[2])[0] - point)
    assert twice == pytest.approx(2 * moved, rel=0.03)


def test_a_shift_moves_the_place_as_far_where_it_is_level() -> None:
    robot = load_robot("nico")
    point = np.array([0.32, -0.16, 0.55])
    camera = EyeCamera(robot, EYE, perturbed(shift=[0.0, 0.01, 0.0]))
    moved = camera.project(camera.actual.pixels_of(point), point[2])[0] - point
    left = camera.believed.pose[:3, 1]
    across = left - left[2] * camera.actual.pose[:3, 0] / camera.actual.pose[2, 0]
    assert moved == pytest.approx(-0.01 * across, abs=1e-3)


def test_a_calibration_error_has_its_size_and_hangs_on_the_seed_alone() -> None:
    wrong = compose(["perception=miscalibrated"]).perception
    size = wrong.calibration_error
    first, again, other = (drawn_offset(size, seed) for seed in (3, 3, 4))
    assert (first == again).all()
    for pose in (first, other):
        assert np.linalg.norm(pose[:3, 3]) == pytest.approx(size.translation)
        # The trace of a rotation is 1 + 2 cos of its angle.
        assert np.arccos((np.trace(pose[:3, :3]) - 1) / 2) == pytest.approx(size.rotation)
    assert np.linalg.norm(first - other) > size.translation
    robot = load_robot("nico")
    camera = EyeCamera(robot, EYE, NOTHING, first)
    assert camera.believed.pose == pytest.approx(mounted(robot).pose)
    assert camera.actual.pose == pytest.approx(mounted(robot).pose @ first)
    assert (wrong.title, CONFIG.perception.title) == ("miscalibrated", "camera")


def test_nothing_is_wrong_unless_requested(studio: Studio) -> None:
    camera = EyeCamera(studio.scene.robot, EYE, NOTHING)
    assert (camera.actual.pose == camera.believed.pose).all()
    assert camera.config == EYE
    plain = EyeCamera(studio.scene.robot, EYE)
    pictures = [each.picture(studio.scene.client) for each in (camera, plain)]
    assert pictures[0].shape == (480, 640, 3)
    assert (pictures[0] == pictures[1]).all()


def test_lighting_makes_the_picture_darker_and_turns_the_shadows(studio: Studio) -> None:
    camera, client = mounted(studio.scene.robot), studio.scene.client
    bright, dark = (take_picture(client, camera, dimmed(EYE, share))[0] for share in (0.0, 1.0))
    assert dark.mean() < 0.85 * bright.mean()
    assert dimmed(EYE, 1.0).light[:2] == pytest.approx([-EYE.light[0], -EYE.light[1]])
    assert dimmed(EYE, 0.0) == EYE


def test_robots_without_an_eye_are_reported_what_is_missing() -> None:
    with pytest.raises(PerceptionError, match="'panda' has no camera"):
        mounted(load_robot("panda"))


def test_an_eye_on_the_arm_is_refused() -> None:
    robot = load_robot("nico")
    assert robot.description.camera is not None
    hand = replace(robot.description.camera, link="right_palm:11")
    robot.description = replace(robot.description, camera=hand)
    with pytest.raises(PerceptionError, match="hangs on r_shoulder_z, a joint of its chain"):
        mounted(robot)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("field_of_view", 190.0, "between 0 and 180 deg"),
        ("width", 640.5, "whole number"),
        ("rotation", [0.0, 1.0], r"shape \(3,\)"),
        ("lens", "wide", "the keys"),
    ],
)
def test_wrong_mounts_are_refused(tmp_path, key: str, value: object, words: str) -> None:
    mount = {"link": "head", "position": [0, 0, 0], "rotation": [0, 0, 0]}
    mount |= {"field_of_view": 60.0, "width": 640, "height": 480, key: value}
    path = tmp_path / "robot.yaml"
    path.write_text(
        f"name: n\ntitle: t\nurdf: u.urdf\nbase: b\ntip: t\ncamera: {mount}\n".replace("'", '"')
    )
    with pytest.raises(DescriptionError, match=words):
        read_description(path)
