"""Detections drawn into a picture."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pillow
from PIL import ImageDraw, ImageFont

from pipeline.perception.detection import Detection

Image = NDArray[np.uint8]


def annotated(
    image: Image, detections: Sequence[Detection], colour_of: Callable[[str], str], size: int = 13
) -> Image:
    """Draw detections into a picture: box, name, score, and a cross at the centroid.

    Args:
        image: Red, green, blue (height, width, 3).
        detections: What was found.
        colour_of: Colour of a class by its name.
        size: Height of the letters [pixels].

    Returns:
        A new picture of the same shape.
    """
    picture = Pillow.fromarray(image)
    canvas, font = ImageDraw.Draw(picture), ImageFont.load_default(size)
    for found in detections:
        colour = colour_of(found.name)
        x0, y0, x1, y1 = found.box
        canvas.rectangle((x0 - 1, y0 - 1, x1 + 1, y1 + 1), outline="white")
        canvas.rectangle((x0, y0, max(x1, x0), max(y1, y0)), outline=colour, width=2)
        draw_cross(canvas, found.centroid, 8, "white", 3)
        draw_cross(canvas, found.centroid, 7, colour, 1)
        text = f"{found.name.replace('_', ' ')} {found.score:.2f}"
        top = y0 - size - 4 if y0 > size + 4 else y1 + 2
        box = canvas.textbbox((x0, top), text, font=font)
        canvas.rectangle((box[0] - 2, box[1] - 1, box[2] + 2, box[3] + 1), fill=colour)
        canvas.text((x0, top), text, fill="white", font=font)
    return np.asarray(picture)


def draw_cross(
    canvas: ImageDraw.ImageDraw,
    centre: Sequence[float],
    reach: float,
    colour: str,
    width: int,
) -> None:
    """Draw an upright cross.

    Args:
        canvas: Of the picture.
        centre: Its middle u, v [pixels].
        reach: From the middle to an end [pixels].
        colour: Of the lines.
        width: Of the lines [pixels].
    """
    u, v = centre
    canvas.line((u - reach, v, u + reach, v), fill=colour, width=width)
    canvas.line((u, v - reach, u, v + reach), fill=colour, width=width)
