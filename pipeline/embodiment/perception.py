"""What the robot knows of its table: from the simulator, or from the image of its camera."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.agent import Seen, seen_at
from pipeline.embodiment.scene_objects import SceneObjects, centre_heights
from pipeline.grasping.config import GraspConfig, SceneConfig
from pipeline.grasping.scene import Scene
from pipeline.perception.camera import EyeCamera, drawn_offset
from pipeline.perception.config import PerceptionConfig
from pipeline.perception.detection import Detection, Detector, Sighting
from pipeline.perception.loading import see
from pipeline.seeding import derive_seed

if TYPE_CHECKING:
    from robots import Robot


@dataclass(frozen=True)
class View:
    """One look at the table.

    Attributes:
        image: Red, green, blue, shape (height, width, 3); None if no picture was taken.
        sightings: What was seen on the table and where.
    """

    image: NDArray[np.uint8] | None
    sightings: list[Sighting]

    def find(self, name: str) -> Sighting | None:
        """The sighting of a name with the highest score."""
        found = [each for each in self.sightings if each.name == name]
        return max(found, key=lambda each: each.score, default=None)

    def seen(self) -> list[Seen]:
        """What the agent receives of it."""
        return [
            seen_at(each.name, float(each.position[0]), float(each.position[1]), each.score)
            for each in self.sightings
        ]


class Perception(Protocol):
    """Where the robot's knowledge of its table comes from."""

    def look(self, scene: Scene, objects: SceneObjects) -> View:
        """Look at the table.

        Args:
            scene: The simulated world.
            objects: What lies in it, which only a perfect sense may use.
        """
        ...


class GroundTruthPerception:
    """Perfect localisation: the simulator gives the places of the objects on the table."""

    def __init__(self, margin: float = 0.0) -> None:
        """Take how far around a bin what lies there counts as in it [m]."""
        self._margin = margin

    def look(self, scene: Scene, objects: SceneObjects) -> View:
        """Return every object that lies on the table, see `Perception.look`."""
        sightings = []
        for each in objects.all:
            position = objects.position(each)
            detection = Detection(each.name, 1.0, (0.0, 0.0, 0.0, 0.0), (0.0, 0.0))
            if position[2] > scene.config.table.height:
                sightings.append(Sighting(detection, position))
        return View(None, outside_bins(sightings, scene.config, self._margin))


class CameraPerception:
    """The camera in the robot's head and a detector."""

    def __init__(
        self, camera: EyeCamera, detector: Detector, heights: Mapping[str, float], margin: float
    ) -> None:
        """Take what sees.

        Args:
            camera: Takes pictures and projects them.
            detector: Finds objects in them.
            heights: Height of the centre of each object, base frame [m].
            margin: How far around a bin what is seen there counts as in it [m].
        """
        self.camera, self.detector = camera, detector
        self._heights, self._margin = heights, margin

    def look(self, scene: Scene, objects: SceneObjects) -> View:
        """Take a picture and find objects in it, see `Perception.look`; `objects` is not used."""
        image = self.camera.picture(scene.client)
        sightings = see(image, self.detector, self.camera, self._heights)
        return View(image, outside_bins(sightings, scene.config, self._margin))


def make_perception(
    perception: PerceptionConfig,
    grasp: GraspConfig,
    robot: Robot,
    detector: Detector | None,
    seed: int,
) -> Perception:
    """Give a robot the senses that a configuration names.

    Args:
        perception: The simulator's word, or a camera's picture.
        grasp: Scene and objects.
        robot: The robot.
        detector: Finds objects in pictures; None where no picture is taken.
        seed: Root seed, that the calibration error is drawn from.

    Raises:
        PerceptionError: The robot has no camera.
    """
    margin = grasp.protocol.bin_margin
    if detector is None:
        return GroundTruthPerception(margin)
    draw = derive_seed(seed, "grasp", robot.name, "calibration error")
    error = drawn_offset(perception.calibration_error, draw)
    camera = EyeCamera(robot, perception.eye, perception.perturbation, error)
    return CameraPerception(
        camera, detector, centre_heights(grasp, grasp.scenes[robot.name]), margin
    )


def outside_bins(
    sightings: Sequence[Sighting], scene: SceneConfig, margin: float
) -> list[Sighting]:
    """Leave out what lies in a bin: it is put away, and no longer on the table.

    Args:
        sightings: What was seen.
        scene: Where the bins stand.
        margin: Width around a bin that counts as part of it [m].
    """
    kept = []
    for each in sightings:
        boxes = scene.bins.values()
        if not any(
            (np.abs(each.position[:2] - box.centre) < 0.5 * np.array(box.size[:2]) + margin).all()
            for box in boxes
        ):
            kept.append(each)
    return kept
