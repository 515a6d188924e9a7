"""Objects of no class: visible to the camera, without contact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pybullet
from numpy.random import Generator

from pipeline.grasping.config import SceneConfig
from pipeline.perception.layout import between

Colour = tuple[float, float, float]
BLOCK = (0.02, 0.06), (0.015, 0.04)  # m, edges and height
PLATE = (0.03, 0.10), (0.002, 0.012)  # m, edges and height
ROD = (0.004, 0.008), (0.06, 0.14)  # m, radius and length
CLEAR = 0.13  # m between a distractor and an object, centre to centre
BEYOND = 0.10  # m beyond the action area
TRIES = 40


def lay_distractors(
    client: Any,
    scene: SceneConfig,
    count: int,
    draw: Generator,
    avoid: Sequence[tuple[float, float]] = (),
    colour: Callable[[], Colour] | None = None,
) -> list[int]:
    """Lay blocks, plates and rods on the table.

    They have no collision shape, so nothing that moves is changed by them.

    Args:
        client: PyBullet client.
        scene: Action area and height of the table.
        count: How many; those that find no free place are left out.
        draw: Random numbers.
        avoid: x and y of the objects that they must not hide, base frame [m].
        colour: Draws red, green, blue of 0 to 1; any colour if not given.

    Returns:
        PyBullet's numbers of the bodies.
    """
    low, high = np.transpose([scene.area.x, scene.area.y])
    bodies = []
    for _ in range(count):
        for _ in range(TRIES):
            place = draw.uniform(low - BEYOND, high + BEYOND)
            if all(np.hypot(*(place - other)) >= CLEAR for other in avoid):
                red, green, blue = draw.uniform(size=3) if colour is None else colour()
                rgba = [float(red), float(green), float(blue), 1.0]
                bodies.append(_body(client, draw, place.tolist(), scene.table.height, rgba))
                break
    return bodies


def _body(
    client: Any, draw: Generator, place: list[float], surface: float, rgba: list[float]
) -> int:
    kind = draw.choice(["block", "plate", "rod"])
    turn = [0.0, 0.0, float(draw.uniform(-np.pi, np.pi))]
    if kind == "rod":
        radius, length = (between(draw, ends) for ends in ROD)
        shape = client.createVisualShape(
            pybullet.GEOM_CAPSULE, radius=radius, length=length, rgbaColor=rgba
        )
        up, turn[1] = 2.0 * radius, 0.5 * np.pi
    else:
        edges, heights = BLOCK if kind == "block" else PLATE
        up = between(draw, heights)
        half = [*(0.5 * draw.uniform(edges[0], edges[1], size=2)).tolist(), 0.5 * up]
        shape = client.createVisualShape(pybullet.GEOM_BOX, halfExtents=half, rgbaColor=rgba)
    return int(
        client.createMultiBody(
            baseMass=0.0,
            baseVisualShapeIndex=shape,
            basePosition=[*place, surface + 0.5 * up],
            baseOrientation=pybullet.getQuaternionFromEuler(turn),
        )
    )
