"""From where a robot is seen and from where it sees: what `robot.yaml` says of cameras."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
FIELD_OF_VIEW_DEG = 28.0  # vertical, of pictures


@dataclass(frozen=True)
class Picture:
    """How the picture in a robot's README is taken; see `robots.picture`.

    Attributes:
        target: (3,) point in the middle of the picture, base of the URDF, m.
        distance: From camera to target, m.
        yaw: Turn of the camera about the vertical, deg.
        pitch: Of the line of sight, deg; negative looks down.
        seed: Of the random postures.
    """

    target: Array
    distance: float
    yaw: float
    pitch: float
    seed: int


@dataclass(frozen=True)
class Camera:
    """A pinhole camera on a link; see `pipeline.perception.camera`.

    Attributes:
        link: Link that carries it.
        position: (3,) of the optical centre, link frame, m.
        rotation: (3,) roll, pitch, yaw, link frame, deg: x along the line of sight, z up in the
            picture, so a positive pitch looks down.
        field_of_view: Vertical, deg.
        width: Of the picture, pixels.
        height: Of the picture, pixels.
    """

    link: str
    position: Array
    rotation: Array
    field_of_view: float
    width: int
    height: int
