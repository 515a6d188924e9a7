"""The embedded detector: the centre-point network behind the protocol."""

from __future__ import annotations

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image as Pillow
from torch import Tensor
from torch.nn import functional

from pipeline.errors import PerceptionError
from pipeline.perception.config import STRIDE, PerceptionConfig
from pipeline.perception.detection import Detection, check_image, distinct
from pipeline.perception.network import CentreNetwork

Image = NDArray[np.uint8]


class EmbeddedDetector:
    """Finds the objects that a centre-point network was trained for.

    Attributes:
        names: Its classes.
    """

    def __init__(self, network: CentreNetwork, config: PerceptionConfig) -> None:
        """Wrap a trained network.

        Args:
            network: In evaluation mode.
            config: Which detections are reported.
        """
        self.names = network.names
        self._network, self._config = network, config

    def detect(self, image: Image) -> list[Detection]:
        """Find objects in a picture (height, width, 3), highest score first.

        Raises:
            PerceptionError: The picture has another shape, type, or ratio of the sides.
        """
        size = self._network.config
        pixels = as_input(image, size.width, size.height)
        with torch.inference_mode():
            logits, offsets = self._network(pixels[None])
        scale = image.shape[1] / size.width
        return decode(logits[0], offsets[0], self.names, scale, self._config)


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
    logits: Tensor, offsets: Tensor, names: tuple[str, ...], scale: float, config: PerceptionConfig
) -> list[Detection]:
    """Read detections off a network's answer.

    Args:
        logits: (classes, rows, columns).
        offsets: (6, rows, columns), cells.
        names: The classes.
        scale: Pixels of the image for each pixel of the network's input.
        config: Least score, number and overlap of what is reported.

    Returns:
        The highest cells among their neighbours, highest score first; of two detections of one
        object, the one with the higher score.
    """
    heat = torch.sigmoid(logits)
    peaks = heat * (heat == functional.max_pool2d(heat[None], 3, 1, 1)[0])
    scores, order = peaks.flatten().topk(min(config.max_detections, peaks.numel()))
    found: list[Detection] = []
    cell = STRIDE * scale
    rows, columns = heat.shape[1:]
    for score, place in zip(scores.tolist(), order.tolist(), strict=True):
        if score < config.threshold:
            break
        kind, inside = divmod(place, rows * columns)
        row, column = divmod(inside, columns)
        du, dv, left, top, right, bottom = offsets[:, row, column].tolist()
        u, v = column + 0.5 + du, row + 0.5 + dv
        sides = (u - left, v - top, u + right, v + bottom)
        x0, y0, x1, y1 = (cell * side for side in sides)
        found.append(Detection(names[kind], score, (x0, y0, x1, y1), (cell * u, cell * v)))
    return distinct(found, config.merge_overlap)
