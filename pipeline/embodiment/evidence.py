"""What is kept of a row: its transcript, and pictures with what was seen drawn into them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw

from pipeline.agent.transcript import write_transcript
from pipeline.data.files import replacing
from pipeline.embodiment.perception import CameraPerception, Perception, View
from pipeline.embodiment.scene_objects import Array
from pipeline.embodiment.session import Episode, Event
from pipeline.perception.drawing import annotated, draw_cross

SEEN, MEANT, TRUE = "#1e6edc", "#dc2828", "#14963c"  # colours of boxes and of crosses
CROSS = 6  # pixels from its middle to an end


def draw_view(
    view: View, perception: Perception, names: Sequence[str], true: Array
) -> Image.Image | None:
    """The picture of a look with boxes, names, scores and centroids of what was seen.

    Args:
        view: The look.
        perception: The source of the view; its camera projects places into the image.
        names: What the trial was about: boxes of these names are red, others blue.
        true: Where objects really lay, base frame [m], shape (N, 3): green crosses.

    Returns:
        The picture, None where none was taken.
    """
    if view.image is None:
        return None
    found = [each.detection for each in view.sightings]
    drawn = annotated(view.image, found, lambda name: MEANT if name in names else SEEN)
    picture = Image.fromarray(drawn)
    if isinstance(perception, CameraPerception):
        canvas = ImageDraw.Draw(picture)
        for centre in perception.camera.pixels_of(true):
            draw_cross(canvas, centre, CROSS, TRUE, 2)
    return picture


def save_picture(picture: Image.Image | None, path: Path) -> str:
    """Write a picture; its name, or nothing if there is none."""
    if picture is None:
        return ""
    with replacing(path) as partial:
        picture.save(partial)
    return path.name


def save_transcript(path: Path, entries: Sequence[dict[str, Any]], episode: Episode) -> str:
    """Write what was said and done as JSON lines; its name.

    Entries of the conversation come first, in order; then one of each action with its result
    and where its target was seen.
    """
    write_transcript(path, [*entries, *(described(event) for event in episode.events)])
    return path.name


def described(event: Event) -> dict[str, Any]:
    """An event as plain values, ready for JSON."""
    entry: dict[str, Any] = {
        "role": "event",
        "time_s": round(event.time_s, 3),
        "kind": event.action.kind,
        "target": event.action.target,
        "text": event.action.text,
        "done": event.result.done,
        "outcome": event.result.words,
    }
    if event.sighting is not None:
        place = np.round(event.sighting.position, 4).tolist()
        entry |= {"place_m": place, "score": round(float(event.sighting.score), 3)}
    if event.view is not None:
        entry["in_view"] = [each.name for each in event.view.sightings]
    return entry
