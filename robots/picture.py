"""The picture of a robot at rest and in five random postures, by PyBullet's software renderer."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pybullet
from numpy.typing import NDArray
from PIL import Image

from robots.description import FILE, Picture
from robots.errors import DescriptionError
from robots.robot import Robot

Array = NDArray[np.float64]

COLUMNS, ROWS = 3, 2
PANEL = (400, 400)  # width and height of one posture, pixels
SUPERSAMPLING = 2  # the software renderer does not smooth edges itself
COLOURS = 220  # of the palette; keeps a picture below 100 kB
BACKGROUND = (250, 250, 252)
FIELD_OF_VIEW_DEG = 28.0
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
    picture = robot.description.picture
    if picture is None:
        raise DescriptionError(
            f"{robot.urdf_path.with_name(FILE)}: no `picture`, expected target [m], distance [m], "
            f"yaw and pitch [deg] of the camera and a seed; see robots/panda/{FILE}"
        )
    postures = np.vstack([robot.home, robot.sample(COLUMNS * ROWS - 1, seed=picture.seed)])
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(robot.urdf_path), useFixedBase=True, physicsClientId=client)
        panels = [_draw(client, body, _positions(robot, q), picture) for q in postures]
    finally:
        pybullet.disconnect(client)
    width, height = PANEL
    sheet = Image.new("RGB", (COLUMNS * width, ROWS * height))
    for number, panel in enumerate(panels):
        row, column = divmod(number, COLUMNS)
        sheet.paste(panel, (column * width, row * height))
    return sheet.quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def _positions(robot: Robot, joints: Array) -> dict[str, float]:
    """Positions by joint name: the chain at `joints` (dof,), the posture of the others."""
    chain = dict(zip(robot.joint_names, joints.tolist(), strict=True))
    return {**robot.description.posture, **chain}


def _draw(client: int, body: int, positions: dict[str, float], picture: Picture) -> Image.Image:
    for joint in range(pybullet.getNumJoints(body, physicsClientId=client)):
        name = pybullet.getJointInfo(body, joint, physicsClientId=client)[1].decode()
        if name in positions:
            pybullet.resetJointState(body, joint, positions[name], physicsClientId=client)
    width, height = (SUPERSAMPLING * side for side in PANEL)
    view = pybullet.computeViewMatrixFromYawPitchRoll(
        picture.target.tolist(), picture.distance, picture.yaw, picture.pitch, 0, 2
    )
    lens = pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW_DEG, width / height, NEAR_M, FAR_M)
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
    pixels[np.reshape(seen, (height, width)) < 0] = BACKGROUND
    return Image.fromarray(pixels).resize(PANEL, Image.Resampling.LANCZOS)
