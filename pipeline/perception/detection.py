"""What a detector says: the protocol between pictures and objects, and objects on the table."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from pipeline.errors import PerceptionError


@dataclass(frozen=True)
class Detection:
    """One object in a picture.

    Pixel (0, 0) is the upper left corner of the upper left pixel, whose centre is (0.5, 0.5).

    Attributes:
        name: Its class.
        score: How sure the detector is, 0 to 1.
        box: x0, y0, x1, y1 around what is seen of it [pixels].
        centroid: u, v of its centre [pixels]: the picture of the middle of the body, which for a
            bent object is not the middle of its box.
    """

    name: str
    score: float
    box: tuple[float, float, float, float]
    centroid: tuple[float, float]


class Detector(Protocol):
    """Finds objects of known classes in a picture.

    Attributes:
        names: The classes.
    """

    names: tuple[str, ...]

    def detect(self, image: NDArray[np.uint8]) -> list[Detection]:
        """Find objects.

        Args:
            image: Red, green, blue, shape (height, width, 3).

        Returns:
            What was found, highest score first.

        Raises:
            PerceptionError: The picture has another shape or type.
        """
        ...


def check_image(image: NDArray[np.uint8]) -> None:
    """Refuse what is no image of shape (height, width, 3) of 8-bit red, green, blue.

    Raises:
        PerceptionError: It has another shape or type.
    """
    if image.ndim != 3 or image.shape[2] != 3 or image.dtype != np.uint8:
        raise PerceptionError(
            "a detector expects an image of shape (height, width, 3) of 8-bit red, green, blue, "
            f"got {image.dtype} {image.shape}"
        )


def overlap(
    first: tuple[float, float, float, float], second: tuple[float, float, float, float]
) -> float:
    """Intersection over union of two boxes."""
    width = min(first[2], second[2]) - max(first[0], second[0])
    height = min(first[3], second[3]) - max(first[1], second[1])
    shared = max(width, 0.0) * max(height, 0.0)
    whole = sum(max(box[2] - box[0], 0.0) * max(box[3] - box[1], 0.0) for box in (first, second))
    return shared / (whole - shared) if whole > shared else 0.0


def distinct(found: Iterable[Detection], merge_overlap: float) -> list[Detection]:
    """Leave out detections of an object that is reported already, whatever their class.

    Args:
        found: Detections, highest score first.
        merge_overlap: Intersection over union above which two are of one object.
    """
    kept: list[Detection] = []
    for each in found:
        if all(overlap(each.box, other.box) <= merge_overlap for other in kept):
            kept.append(each)
    return kept


@dataclass(frozen=True)
class Sighting:
    """A detection with its place.

    Attributes:
        detection: What was seen in the picture.
        position: x, y, z of its centre, base frame [m], on the plane of the centroid height of its
            class, shape (3,).
    """

    detection: Detection
    position: NDArray[np.float64]

    @property
    def name(self) -> str:
        """Its class."""
        return self.detection.name

    @property
    def score(self) -> float:
        """How sure the detector is, 0 to 1."""
        return self.detection.score
