"""Detections held against labels: a raw row for each object, and for each detection of none."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.errors import PerceptionError
from pipeline.evaluation.detections import FALSE, FOUND, MISSED
from pipeline.perception.detection import Detection, Detector, overlap
from pipeline.perception.pictures import Pictures
from pipeline.perception.pinhole import Pinhole
from pipeline.perception.studio import Label

Array = NDArray[np.float64]


def judge(
    detector: Detector, pictures: Pictures, least: float, progress: Callable[[], object]
) -> pd.DataFrame:
    """Detect in every picture: a row for each object and for each detection that is none.

    Detections of all scores are kept, so that precision and recall follow at any threshold.

    Args:
        detector: Its least score should be near 0.
        pictures: Pictures with labels.
        least: Intersection over union from which on an object of the class counts as found.
        progress: Called after each picture.

    Returns:
        Columns picture, name, kind (found, missed, false), score, overlap, x_m, y_m (true place),
        seen_x_m, seen_y_m (where it was seen), error_m, pixel_error.
    """
    rows: list[dict[str, Any]] = []
    for number in range(len(pictures)):
        image = np.asarray(pictures.images[number])
        found = detector.detect(image)
        each = match(found, pictures.labels[number], pictures.cameras[number], least)
        rows += [{"picture": number, **row} for row in each]
        progress()
    return pd.DataFrame(rows)


def match(
    found: Iterable[Detection], labels: list[Label], camera: Pinhole, least: float
) -> list[dict[str, Any]]:
    """Pair the detections of a picture with its labels, highest score first, each label once.

    The place is that of the centroid pixel through the camera that took the picture, on the plane
    of the true centre's height: a calibrated robot.
    """
    rows: list[dict[str, Any]] = []
    open_labels = list(labels)
    for detection in sorted(found, key=lambda each: -each.score):
        same = [label for label in open_labels if label.name == detection.name]
        best = max(same, key=lambda label: overlap(detection.box, label.box), default=None)
        shared = overlap(detection.box, best.box) if best else 0.0
        row = {"name": detection.name, "score": detection.score, "overlap": shared}
        if best is None or shared < least:
            rows.append({**row, "kind": FALSE, **_places(None, None)})
            continue
        open_labels.remove(best)
        seen = _seen(detection, camera, best.position[2])
        pixels = float(np.hypot(*np.subtract(detection.centroid, best.centroid)))
        rows.append({**row, "kind": FOUND, **_places(best, seen), "pixel_error": pixels})
    nothing = {"score": 0.0, "overlap": 0.0, "kind": MISSED}
    rows += [{"name": label.name, **nothing, **_places(label, None)} for label in open_labels]
    return rows


def _seen(detection: Detection, camera: Pinhole, height: float) -> Array | None:
    try:
        place: Array = camera.project([detection.centroid], height)[0]
    except PerceptionError:
        return None
    return place


def _places(label: Label | None, seen: Array | None) -> dict[str, float]:
    true = np.full(2, np.nan) if label is None else np.array(label.position[:2])
    there = np.full(2, np.nan) if seen is None else seen[:2]
    return {
        "x_m": float(true[0]),
        "y_m": float(true[1]),
        "seen_x_m": float(there[0]),
        "seen_y_m": float(there[1]),
        "error_m": float(np.hypot(*(there - true))),
        "pixel_error": float("nan"),
    }
