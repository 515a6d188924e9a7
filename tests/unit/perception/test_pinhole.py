"""The pinhole model against PyBullet's own matrices, and there and back."""

from __future__ import annotations

import numpy as np
import pybullet
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import PerceptionError
from pipeline.perception.pinhole import Pinhole

EYE, TARGET = np.array([0.1, -0.05, 0.95]), np.array([0.35, -0.2, 0.5])
VIEW, SIZE = 54.0, (640, 480)


def looking(eye: np.ndarray, target: np.ndarray) -> Pinhole:
    """A camera without roll."""
    ahead = (target - eye) / np.linalg.norm(target - eye)
    left = np.cross([0.0, 0.0, 1.0], ahead)
    left /= np.linalg.norm(left)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([ahead, left, np.cross(ahead, left)], axis=1)
    pose[:3, 3] = eye
    return Pinhole.from_view(pose, VIEW, *SIZE)


def test_matrices_are_those_of_pybullet() -> None:
    camera = looking(EYE, TARGET)
    view = pybullet.computeViewMatrix(EYE.tolist(), TARGET.tolist(), [0, 0, 1])
    lens = pybullet.computeProjectionMatrixFOV(VIEW, SIZE[0] / SIZE[1], 0.05, 4.0)
    assert camera.view_matrix() == pytest.approx(view, abs=1e-6)
    assert camera.projection_matrix(0.05, 4.0) == pytest.approx(lens, abs=1e-5)


def test_pixels_follow_from_pybullets_matrices() -> None:
    camera = looking(EYE, TARGET)
    points = np.random.default_rng(0).uniform([0.2, -0.4, 0.4], [0.5, 0.1, 0.6], (50, 3))
    view = np.reshape(pybullet.computeViewMatrix(EYE.tolist(), TARGET.tolist(), [0, 0, 1]), (4, 4))
    lens = pybullet.computeProjectionMatrixFOV(VIEW, SIZE[0] / SIZE[1], 0.05, 4.0)
    clip = np.c_[points, np.ones(50)] @ view @ np.reshape(lens, (4, 4))
    x, y = (clip[:, :2] / clip[:, 3:]).T  # OpenGL: -1 to 1, up
    expected = np.stack([0.5 * (x + 1) * SIZE[0], 0.5 * (1 - y) * SIZE[1]], axis=1)
    assert camera.pixels_of(points) == pytest.approx(expected, abs=1e-3)


@settings(max_examples=60, deadline=None)
@given(
    place=st.tuples(st.floats(0.15, 0.8), st.floats(-0.6, 0.6)),
    height=st.floats(0.0, 0.7),
)
def test_there_and_back(place: tuple[float, float], height: float) -> None:
    camera, point = looking(EYE, TARGET), np.array([*place, height])
    back = camera.project(camera.pixels_of(point), height)[0]
    assert back == pytest.approx(point, abs=1e-9)


def test_a_point_behind_the_camera_has_no_pixel() -> None:
    camera = looking(EYE, TARGET)
    assert np.isnan(camera.pixels_of(2 * EYE - TARGET)).all()


@pytest.mark.parametrize("height", [1.5, float("nan")])
def test_a_plane_that_a_ray_does_not_meet_is_refused(height: float) -> None:
    camera = looking(EYE, TARGET)
    with pytest.raises(PerceptionError, match="does not look at the plane"):
        camera.project([[320.0, 240.0]], height)


def test_pixels_above_the_horizon_are_refused() -> None:
    level = looking(EYE, np.add(EYE, [1.0, 0.0, 0.0]))
    assert level.project([[320.0, 400.0]], 0.5).shape == (1, 3)
    with pytest.raises(PerceptionError, match="below the horizon"):
        level.project([[320.0, 400.0], [320.0, 100.0]], 0.5)
