"""The embedded detector: the centre-point network behind the protocol."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image as Pillow
from torch import Tensor
from torch.nn import functional

from pipeline.errors import PerceptionError
from pipeline.perception.config import STRIDE
from pipeline.perception.detection import Detection, check_image
from pipeline.perception.network import CentreNetwork

Image = NDArray[np.uint8]
MOST = 40  # detections of one picture
SAME = 0.6  # intersection over union above which two detections are of one object


class EmbeddedDetector:
    """Finds the objects that a centre-point network was trained for.

    Attributes:
        names: Its classes.
    """

    def __init__(self, network: CentreNetwork, threshold: float) -> None:
        """Wrap a trained network.

        Args:
            network: In evaluation mode.
            threshold: Least score.
        """
        self.names = network.names
        self._network, self._threshold = network, threshold

    def detect(self, image: Image) -> list[Detection]:
        """Find objects in a picture (height, width, 3), highest score first.

        Raises:
            PerceptionError: The picture has another shape, type, or ratio of the sides.
        """
        config = self._network.config
        pixels = as_input(image, config.width, config.height)
        with torch.inference_mode():
            logits, offsets = self._network(pixels[None])
        scale = image.shape[1] / config.width
        return decode(logits[0], offsets[0], self.names, self._threshold, scale)


def as_input(image: Image, width: int, height: int) -> Tensor:
    """Reduce a picture to the network's input, (3, height, width), 0 to 1.

    Raises:
        PerceptionError: The picture has another shape, type, or ratio of the sides.
    """
    check_image(image)
    if image.shape[0] * width != image.shape[1] * height:
        raise PerceptionError(
            f"the detector expects pictures of {width} x {height} pixels or a multiple, got "
            f"{image.shape[1]} x {image.shape[0]}"
        )
    if image.shape[:2] != (height, width):
        reduced = Pillow.fromarray(image).resize((width, height), Pillow.Resampling.BOX)
        image = np.asarray(reduced)
    return torch.from_numpy(image.copy()).permute(2, 0, 1).float() / 255.0


def decode(
    logits: Tensor, offsets: Tensor, names: tuple[str, ...], threshold: float, scale: float
) -> list[Detection]:
    """Read detections off a network's answer.

    Args:
        logits: (classes, rows, columns).
        offsets: (6, rows, columns), cells.
        names: The classes.
        threshold: Least score.
        scale: Pixels of the picture for each pixel of the network's input.

    Returns:
        The highest cells among their neighbours, highest score first; of two detections of one
        object, the one with the higher score.
    """
    heat = torch.sigmoid(logits)
    peaks = heat * (heat == functional.max_pool2d(heat[None], 3, 1, 1)[0])
    scores, order = peaks.flatten().topk(min(MOST, peaks.numel()))
    kept: list[Detection] = []
    cell = STRIDE * scale
    rows, columns = heat.shape[1:]
    for score, place in zip(scores.tolist(), order.tolist(), strict=True):
        if score < threshold:
            break
        kind, inside = divmod(place, rows * columns)
        row, column = divmod(inside, columns)
        du, dv, left, top, right, bottom = offsets[:, row, column].tolist()
        u, v = column + 0.5 + du, row + 0.5 + dv
        sides = (u - left, v - top, u + right, v + bottom)
        x0, y0, x1, y1 = (cell * side for side in sides)
        found = Detection(names[kind], score, (x0, y0, x1, y1), (cell * u, cell * v))
        if all(overlap(found.box, other.box) <= SAME for other in kept):
            kept.append(found)
    return kept


def overlap(
    first: tuple[float, float, float, float], second: tuple[float, float, float, float]
) -> float:
    """Intersection over union of two boxes."""
    width = min(first[2], second[2]) - max(first[0], second[0])
    height = min(first[3], second[3]) - max(first[1], second[1])
    shared = max(width, 0.0) * max(height, 0.0)
    whole = sum(max(box[2] - box[0], 0.0) * max(box[3] - box[1], 0.0) for box in (first, second))
    return shared / (whole - shared) if whole > shared else 0.0
