"""Bodies built from primitives: table, bins and the objects to grasp, and how far these reach."""

from __future__ import annotations

from typing import Any

import numpy as np
import pybullet
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from pipeline.grasping.config import BinConfig, ObjectConfig, PartConfig, TableConfig

TABLE_COLOUR = (0.78, 0.66, 0.50, 1.0)
BIN_COLOUR = (0.35, 0.45, 0.60, 1.0)


def make_object(
    client: Any, obj: ObjectConfig, position: ArrayLike, yaw: float, surface: float
) -> int:
    """Lay an object on a surface.

    Args:
        client: PyBullet client.
        obj: Parts, mass and contact of the object.
        position: x and y of its centre, base frame [m].
        yaw: Rotation about the vertical [rad].
        surface: Height of the surface, base frame [m].

    Returns:
        PyBullet's number of the body.
    """
    collision, visual = _compound(client, obj.parts)
    x, y = np.asarray(position, dtype=np.float64)[:2]
    # Half a millimetre of air: bodies that start in contact are pushed apart.
    height = surface + 0.5 * obj.height + 5e-4
    body = client.createMultiBody(
        baseMass=obj.mass,
        baseCollisionShapeIndex=collision,
        baseVisualShapeIndex=visual,
        basePosition=[x, y, height],
        baseOrientation=pybullet.getQuaternionFromEuler([0.0, 0.0, yaw]),
    )
    contact: dict[str, float | None] = {
        "lateralFriction": obj.friction,
        "rollingFriction": obj.rolling_friction,
        "spinningFriction": obj.spinning_friction,
        "frictionAnchor": 1,
    }
    if obj.stiffness is not None:
        contact |= {"contactStiffness": obj.stiffness, "contactDamping": obj.damping}
    client.changeDynamics(body, -1, **contact)
    return int(body)


def make_table(client: Any, table: TableConfig) -> int | None:
    """Put the table top in place; None where the robot's description has it."""
    if table.size is None or table.centre is None:
        return None
    centre = [*table.centre, table.height - 0.5 * table.size[2]]
    body = _box(client, table.size, centre, TABLE_COLOUR)
    client.changeDynamics(body, -1, lateralFriction=table.friction)
    return body


def make_bin(client: Any, box: BinConfig) -> list[int]:
    """Put an open box in place: a floor and four walls, all fixed."""
    x, y = box.centre
    length, width, height = box.size
    thick = box.wall
    middle = box.floor + 0.5 * height
    plates = [
        ([length, width, thick], [x, y, box.floor + 0.5 * thick]),
        ([thick, width, height], [x - 0.5 * (length - thick), y, middle]),
        ([thick, width, height], [x + 0.5 * (length - thick), y, middle]),
        ([length - 2 * thick, thick, height], [x, y - 0.5 * (width - thick), middle]),
        ([length - 2 * thick, thick, height], [x, y + 0.5 * (width - thick), middle]),
    ]
    return [_box(client, size, centre, BIN_COLOUR) for size, centre in plates]


def _box(client: Any, size: list[float], centre: list[float], colour: tuple[float, ...]) -> int:
    half = [0.5 * edge for edge in size]
    return int(
        client.createMultiBody(
            baseMass=0.0,
            baseCollisionShapeIndex=client.createCollisionShape(
                pybullet.GEOM_BOX, halfExtents=half
            ),
            baseVisualShapeIndex=client.createVisualShape(
                pybullet.GEOM_BOX, halfExtents=half, rgbaColor=colour
            ),
            basePosition=centre,
        )
    )


def _compound(client: Any, parts: list[PartConfig]) -> tuple[int, int]:
    """Collision and visual shape of all parts together."""
    positions = [part.position for part in parts]
    rotations = [
        pybullet.getQuaternionFromEuler(np.deg2rad(part.rotation).tolist()) for part in parts
    ]
    kinds = [_kind(part.shape) for part in parts]
    radii = [0.0 if part.shape == "box" else part.size[0] for part in parts]
    lengths = [part.size[1] if len(part.size) == 2 else 0.0 for part in parts]
    halves = [
        [0.5 * edge for edge in part.size] if part.shape == "box" else [0.0] * 3 for part in parts
    ]
    collision = client.createCollisionShapeArray(
        shapeTypes=kinds,
        radii=radii,
        lengths=lengths,
        halfExtents=halves,
        collisionFramePositions=positions,
        collisionFrameOrientations=rotations,
    )
    visual = client.createVisualShapeArray(
        shapeTypes=kinds,
        radii=radii,
        lengths=lengths,
        halfExtents=halves,
        rgbaColors=[part.colour for part in parts],
        visualFramePositions=positions,
        visualFrameOrientations=rotations,
    )
    return collision, visual


def _kind(shape: str) -> int:
    return {
        "sphere": pybullet.GEOM_SPHERE,
        "capsule": pybullet.GEOM_CAPSULE,
        "cylinder": pybullet.GEOM_CYLINDER,
        "box": pybullet.GEOM_BOX,
    }[shape]


def extent(obj: ObjectConfig, yaw: float, direction: ArrayLike) -> tuple[float, float]:
    """Least and largest coordinate of an object along a direction, from its centre.

    Args:
        obj: Parts of the object.
        yaw: Its rotation about the vertical [rad].
        direction: Unit vector, base frame, shape (3,).

    Returns:
        From and to [m]; the first is negative where the object surrounds its centre.
    """
    axis = Rotation.from_euler("z", yaw).inv().apply(np.asarray(direction, dtype=np.float64))
    ends = []
    for part in obj.parts:
        middle = float(np.dot(part.position, axis))
        half = _half(
            part, Rotation.from_euler("xyz", part.rotation, degrees=True).inv().apply(axis)
        )
        ends.append((middle - half, middle + half))
    return min(low for low, _ in ends), max(high for _, high in ends)


def _half(part: PartConfig, axis: np.ndarray) -> float:
    """Half the length of a primitive along an axis of its own frame [m]; its own axis is z."""
    if part.shape == "box":
        return float(0.5 * np.abs(axis) @ np.asarray(part.size))
    radius = part.size[0]
    if part.shape == "sphere":
        return radius
    along = 0.5 * part.size[1] * abs(float(axis[2]))
    if part.shape == "capsule":
        return along + radius
    return along + radius * float(np.hypot(axis[0], axis[1]))
