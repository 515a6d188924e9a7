"""Load a detector by its configuration, and see: from a picture to objects on the table."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import PerceptionError
from pipeline.perception.camera import EyeCamera
from pipeline.perception.config import PerceptionConfig
from pipeline.perception.detection import Detector, Sighting
from pipeline.perception.embedded import EmbeddedDetector
from pipeline.perception.weights import load_centre_network, shipped_detector

if TYPE_CHECKING:
    from robots import Robot


def load_detector(
    config: PerceptionConfig, robot: Robot, names: Collection[str] | None = None
) -> Detector:
    """Load the detector that a configuration names.

    Args:
        config: Kind of detector, its weights or model, and the least score.
        robot: Whose objects it is to find.
        names: Classes that it must know; for the embedded one those of its card if not given.

    Raises:
        PerceptionError: There are no weights, or they are of another robot or of other objects; a
            model of the user's cannot be loaded.
    """
    if config.detector == "open_vocabulary":
        from pipeline.perception.open_vocabulary import OpenVocabularyDetector

        return OpenVocabularyDetector(config, sorted(names or ()))
    folder = Path(config.weights) if config.weights else shipped_detector(robot.name)
    return EmbeddedDetector(load_centre_network(folder, robot.name, names), config)


def see(
    image: NDArray[np.uint8], detector: Detector, camera: EyeCamera, heights: Mapping[str, float]
) -> list[Sighting]:
    """Find objects in a picture and their places on the table.

    Args:
        image: Red, green, blue, shape (height, width, 3).
        detector: Finds objects.
        camera: Has taken the picture.
        heights: z of the centre of each class as it lies on the table, base frame [m]; a class that
            is not in it is not seen.

    Returns:
        What was found and where, highest score first. A detection whose pixel does not meet the
        plane of its class is left out.
    """
    sightings = []
    for detection in detector.detect(image):
        if detection.name not in heights:
            continue
        try:
            place = camera.project([detection.centroid], heights[detection.name])[0]
        except PerceptionError:
            continue
        sightings.append(Sighting(detection, place))
    return sightings
