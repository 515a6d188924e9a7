"""Pictures of what a detector finds, and how far off it is."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image as Pillow

from pipeline.data.files import replacing
from pipeline.evaluation.detections import FOUND
from pipeline.perception.detection import Detector
from pipeline.perception.drawing import annotated
from pipeline.perception.pictures import Pictures
from pipeline.presentation.style import LOOKS, legend_below, panels, save, styled

COLUMNS = 4  # pictures side by side
TILE = 400  # pixels, width of a picture in the sheet
DPI = 150


def draw_detections(path: Path, detector: Detector, pictures: Pictures, count: int) -> Path:
    """Draw a sheet of the first pictures of a set with what is found in them."""
    colours = {name: LOOKS[k % len(LOOKS)].colour for k, name in enumerate(detector.names)}
    tiles = []
    for number in range(min(count, len(pictures))):
        image = np.asarray(pictures.images[number])
        shown = annotated(image, detector.detect(image), colours.__getitem__)
        height = round(TILE * image.shape[0] / image.shape[1])
        tiles.append(Pillow.fromarray(shown).resize((TILE, height), Pillow.Resampling.LANCZOS))
    rows = -(-len(tiles) // COLUMNS)
    sheet = Pillow.new("RGB", (COLUMNS * TILE, rows * tiles[0].height), "white")
    for number, tile in enumerate(tiles):
        row, column = divmod(number, COLUMNS)
        sheet.paste(tile, (column * TILE, row * tile.height))
    with replacing(path) as partial:
        sheet.save(partial, format="PNG", optimize=True)
    return path


def draw_errors(folder: Path, rows: pd.DataFrame, names: Sequence[str]) -> list[Path]:
    """Draw the share of objects within an error, and where on the table the errors are."""
    found = rows[rows.kind == FOUND]
    with styled():
        figure, (share, place) = panels(2, 3.6, 3.0)
        for name, look in zip(names, LOOKS, strict=False):
            part = found[found.name == name]
            errors = np.sort(1e3 * part.error_m.to_numpy(dtype=float))
            label = name.replace("_", " ")
            share.plot(
                errors,
                100.0 * np.arange(1, len(errors) + 1) / max(len(errors), 1),
                color=look.colour,
                linestyle=look.line,
                label=label,
            )
            place.scatter(
                -part.y_m, part.x_m, s=2e6 * part.error_m**2, color=look.colour, alpha=0.5, lw=0
            )
        share.set_xlabel("position error [mm]")
        share.set_ylabel("objects found within it [%]")
        share.set_xlim(left=0.0)
        place.set_xlabel("to the robot's right [m]")
        place.set_ylabel("ahead of it [m]")
        place.set_title("diameter: error, enlarged", fontsize="small")
        place.set_aspect("equal", adjustable="datalim")
        legend_below(figure, [share])
        return save(figure, folder, "errors", DPI)
