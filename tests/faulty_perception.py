"""Senses that see what the simulator tells, but for the faults that a test asks for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from pipeline.embodiment.perception import GroundTruthPerception, View
from pipeline.embodiment.scene_objects import SceneObjects
from pipeline.grasping.scene import Scene
from pipeline.perception.detection import Sighting


class Faulty(GroundTruthPerception):
    """Perfect senses with faults by name: missing, as:NAME, or metres to the left."""

    def __init__(self, faults: dict[str, str | float]) -> None:
        super().__init__()
        self.faults = faults
        self.looks = 0

    def look(self, scene: Scene, objects: SceneObjects) -> View:
        self.looks += 1
        view = super().look(scene, objects)
        return replace(view, sightings=[s for each in view.sightings for s in self._seen(each)])

    def _seen(self, each: Sighting) -> list[Sighting]:
        fault = self.faults.get(each.name)
        if fault == "missing":
            return []
        if isinstance(fault, str):
            name = fault.removeprefix("as:")
            return [replace(each, detection=replace(each.detection, name=name))]
        return [replace(each, position=each.position + np.array([0.0, fault or 0.0, 0.0]))]
