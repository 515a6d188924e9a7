"""The picture of a robot at rest and in five random postures, by PyBullet's software renderer."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pybullet
from numpy.typing import NDArray
from PIL import Image

from robots.description import FILE
from robots.errors import DescriptionError
from robots.native_output import stdout_elsewhere
from robots.robot import Robot
from robots.viewpoints import FIELD_OF_VIEW_DEG, Picture

Array = NDArray[np.float64]

COLUMNS, ROWS = 3, 2
PANEL = (400, 400)  # width and height of one posture, pixels
SUPERSAMPLING = 2  # the software renderer does not smooth edges itself
COLOURS = 220  # of the palette; keeps a picture below 100 kB
OPACITY = 0.3  # of each posture where several are drawn over each other
BACKGROUND = (250, 250, 252)
NEAR_M, FAR_M = 0.1, 20.0
LIGHT = {
    "lightDirection": [1.2, -1.6, 2.6],
    "lightDistance": 6,
    "shadow": 1,
    "lightAmbientCoeff": 0.6,
    "lightDiffuseCoeff": 0.45,
    "lightSpecularCoeff": 0.12,
}


def write_picture(robot: Robot) -> Path:
    """Write `<name>.png` beside the robot's URDF; the same robot gives the same picture.

    Args:
        robot: A robot whose `robot.yaml` has a `picture`.

    Returns:
        The picture's path.

    Raises:
        DescriptionError: If `robot.yaml` does not say where the picture is taken from.
    """
    path = robot.urdf_path.with_suffix(".png")
    sheet = draw_postures(robot)
    aside = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        sheet.save(aside, format="PNG", optimize=True)
        aside.replace(path)
    finally:
        aside.unlink(missing_ok=True)
    return path


def draw_postures(robot: Robot) -> Image.Image:
    """Draw a robot at home and in five uniform collision-free postures, three in a row.

    Args:
        robot: A robot whose `robot.yaml` has a `picture`: camera and seed.

    Raises:
        DescriptionError: If it has none.
    """
    picture = _picture(robot)
    postures = np.vstack([robot.home, robot.sample(COLUMNS * ROWS - 1, seed=picture.seed)])
    panels = [_shrunk(pixels) for pixels, _ in _renderings(robot, postures, picture)]
    width, height = PANEL
    sheet = Image.new("RGB", (COLUMNS * width, ROWS * height))
    for number, panel in enumerate(panels):
        row, column = divmod(number, COLUMNS)
        sheet.paste(panel, (column * width, row * height))
    return sheet.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def draw_overlay(robot: Robot, postures: Array) -> Image.Image:
    """Draw a robot in several postures at once, each translucent.

    Args:
        robot: A robot whose `robot.yaml` has a `picture`: the camera.
        postures: (N, dof) joints, rad or m.

    Raises:
        DescriptionError: If it has none.
    """
    colour = np.zeros((*_resolution()[::-1], 3))
    weight = np.zeros(_resolution()[::-1])
    for pixels, seen in _renderings(robot, postures, _picture(robot)):
        colour[seen] += pixels[seen]
        weight += seen
    cover = (1 - (1 - OPACITY) ** weight)[..., None]
    mean = colour / np.maximum(weight, 1)[..., None]
    blended = cover * mean + (1 - cover) * np.array(BACKGROUND)
    return _shrunk(blended.round().astype(np.uint8))


def _picture(robot: Robot) -> Picture:
    picture = robot.description.picture
    if picture is None:
        raise DescriptionError(
            f"{robot.urdf_path.with_name(FILE)}: no `picture`, expected target [m], distance [m], "
            f"yaw and pitch [deg] of the camera and a seed; see robots/panda/{FILE}"
        )
    return picture


def _renderings(
    robot: Robot, postures: Array, picture: Picture
) -> Iterator[tuple[NDArray[np.uint8], NDArray[np.bool_]]]:
    """Pixels (H, W, 3) of each posture, and where the robot is seen (H, W)."""
    robot.urdf.require_shapes("visual")
    with stdout_elsewhere(shown=False):
        client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(robot.urdf_path), useFixedBase=True, physicsClientId=client)
        for joints in postures:
            yield _draw(client, body, robot.positions(joints), picture)
    finally:
        pybullet.disconnect(client)


def _resolution() -> tuple[int, int]:
    return SUPERSAMPLING * PANEL[0], SUPERSAMPLING * PANEL[1]


def _shrunk(pixels: NDArray[np.uint8]) -> Image.Image:
    return Image.fromarray(pixels).resize(PANEL, Image.Resampling.LANCZOS)


def _draw(
    client: int, body: int, positions: dict[str, float], picture: Picture
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    for joint in range(pybullet.getNumJoints(body, physicsClientId=client)):
        name = pybullet.getJointInfo(body, joint, physicsClientId=client)[1].decode()
        if name in positions:
            pybullet.resetJointState(body, joint, positions[name], physicsClientId=client)
    width, height = _resolution()
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        picture.target.tolist(), picture.distance, picture.yaw, picture.pitch, 0, 2
    )
    near, far = min(NEAR_M, picture.distance / 10), max(FAR_M, 3 * picture.distance)
    lens = pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW_DEG, width / height, near, far)
    _, _, colours, _, seen = pybullet.getCameraImage(
        width,
        height,
        view,
        lens,
        renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=client,
        **LIGHT,
    )
    pixels = np.reshape(colours, (height, width, 4))[..., :3].astype(np.uint8)
    robot_seen = np.reshape(seen, (height, width)) >= 0
    pixels[~robot_seen] = BACKGROUND
    return pixels, robot_seen
