"""Pictures of a scene by the software renderer: no display, no graphics card."""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet
from numpy.typing import ArrayLike, NDArray

from pipeline.grasping.camera_config import CameraConfig, VideoConfig

Frame = NDArray[np.uint8]
FIELD_OF_VIEW = 45.0  # deg
NEAR, FAR = 0.05, 5.0  # m
SKY = ((205, 216, 226), (246, 248, 250))  # behind everything: colour at the top and at the bottom
FRAME_COLOUR, FRAME_WIDTH = (40, 44, 52), 2  # around the close-up [pixels]
MARGIN = 8  # pixels between the close-up and the picture's edge


def render(client: Any, camera: CameraConfig, size: VideoConfig, follow: ArrayLike) -> Frame:
    """One picture, with a close-up of the hand in a corner.

    Args:
        client: PyBullet client.
        camera: Where to look from, and from how near at the hand.
        size: Width and height [pixels], share of the height for the close-up.
        follow: What the second camera looks at, base frame [m], shape (3,).

    Returns:
        Colours, shape (height, width, 3).
    """
    whole = (camera.distance, camera.yaw, camera.pitch)
    picture = _view(client, camera.target, whole, (size.width, size.height))
    edge = int(size.closeup * size.height)
    if edge > 0:
        detail = (camera.closeup.distance, camera.closeup.yaw, camera.pitch)
        near = _view(client, follow, detail, (edge, edge))
        framed = np.full((edge + 2 * FRAME_WIDTH,) * 2 + (3,), FRAME_COLOUR, dtype=np.uint8)
        framed[FRAME_WIDTH:-FRAME_WIDTH, FRAME_WIDTH:-FRAME_WIDTH] = near
        top = MARGIN if "upper" in camera.closeup.corner else size.height - MARGIN - len(framed)
        left = MARGIN if "left" in camera.closeup.corner else size.width - MARGIN - len(framed)
        picture[top : top + len(framed), left : left + len(framed)] = framed
    return picture


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
