"""Pictures of a scene by the software renderer: no display, no graphics card."""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet
from numpy.typing import ArrayLike, NDArray

from pipeline.grasping.config import CameraConfig, VideoConfig

Frame = NDArray[np.uint8]
FIELD_OF_VIEW = 45.0  # deg
NEAR, FAR = 0.05, 5.0  # m
SKY = ((205, 216, 226), (246, 248, 250))  # behind everything: colour at the top and at the bottom
GAP = 4  # pixels between the two pictures


def render(client: Any, camera: CameraConfig, size: VideoConfig, follow: ArrayLike) -> Frame:
    """One picture, with a close-up of the hand on its right.

    Args:
        client: PyBullet client.
        camera: Where to look from, and from how near at the hand.
        size: Width and height, and width of the close-up [pixels].
        follow: What the second camera looks at, base frame [m], shape (3,).

    Returns:
        Colours, shape (height, width, 3); `frame_width` is the width.
    """
    whole = (camera.distance, camera.yaw, camera.pitch)
    picture = _view(client, camera.target, whole, (size.width, size.height))
    if size.closeup == 0:
        return picture
    detail = (camera.closeup.distance, camera.closeup.yaw, camera.pitch)
    near = _view(client, follow, detail, (size.closeup, size.height))
    gap = np.full((size.height, GAP, 3), 255, dtype=np.uint8)
    return np.concatenate([picture, gap, near], axis=1)


def frame_width(size: VideoConfig) -> int:
    """Width of the pictures of `render` [pixels]."""
    return size.width + (GAP + size.closeup if size.closeup else 0)


def _view(
    client: Any, target: ArrayLike, eye: tuple[float, float, float], size: tuple[int, int]
) -> Frame:
    """Look at a target from a distance [m], yaw and pitch [deg]."""
    distance, yaw, pitch = eye
    width, height = size
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        np.asarray(target).tolist(), distance, yaw, pitch, 0.0, 2
    )
    projection = pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW, width / height, NEAR, FAR)
    image = client.getCameraImage(
        width,
        height,
        view,
        projection,
        lightDirection=[1.0, -0.6, 2.0],
        shadow=1,
        renderer=pybullet.ER_TINY_RENDERER,
        flags=pybullet.ER_NO_SEGMENTATION_MASK,
    )
    colours = np.reshape(np.asarray(image[2], dtype=np.uint8), (height, width, 4))
    depth = np.reshape(np.asarray(image[3]), (height, width))
    sky = np.linspace(*SKY, height).astype(np.uint8)[:, None]
    return np.where((depth >= 1.0)[:, :, None], sky, colours[:, :, :3])
