"""What really lies on the table: the judge's knowledge, which the robot does not have."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pipeline.grasping.config import GraspConfig, SceneConfig
from pipeline.grasping.placements import Setup
from pipeline.grasping.scene import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SceneObject:
    """One object in the simulator.

    Attributes:
        body: PyBullet's number of it.
        setup: What it is and where it was laid.
    """

    body: int
    setup: Setup

    @property
    def name(self) -> str:
        """Which object it is."""
        return self.setup.name


class SceneObjects:
    """All objects of a scene."""

    def __init__(self, scene: Scene, config: GraspConfig, setups: Sequence[Setup]) -> None:
        """Lay them; only before the simulation runs."""
        self._scene = scene
        self.all = [
            SceneObject(scene.lay(config.objects[each.name], each.place, each.yaw), each)
            for each in setups
        ]

    def position(self, obj: SceneObject) -> Array:
        """Centre of an object, base frame [m], shape (3,)."""
        return np.array(self._scene.client.getBasePositionAndOrientation(obj.body)[0])

    def positions(self) -> Array:
        """Centres of all objects, base frame [m], shape (N, 3)."""
        return np.array([self.position(each) for each in self.all])

    def nearest(self, place: ArrayLike) -> tuple[SceneObject, float]:
        """The object whose centre is nearest to a place, and how far it is over the table [m]."""
        there = np.asarray(place, dtype=np.float64)[:2]
        away = np.linalg.norm(self.positions()[:, :2] - there, axis=1)
        best = int(np.argmin(away))
        return self.all[best], float(away[best])

    def named(self, name: str) -> SceneObject | None:
        """The first object of a name."""
        return next((each for each in self.all if each.name == name), None)


def centre_heights(config: GraspConfig, scene: SceneConfig) -> dict[str, float]:
    """Height of the centre of each object of a scene as it lies on the table, base frame [m]."""
    return {name: scene.table.height + 0.5 * config.objects[name].height for name in scene.objects}
