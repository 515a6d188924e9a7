"""Detections held against labels: raw rows, and the figures that follow from them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from pipeline.perception.detection import Detection, Detector
from pipeline.perception.embedded import overlap
from pipeline.perception.errors import PerceptionError
from pipeline.perception.pictures import Pictures
from pipeline.perception.pinhole import Pinhole
from pipeline.perception.studio import Label

Array = NDArray[np.float64]
FOUND, MISSED, FALSE = "found", "missed", "false"


def judge(
    detector: Detector, pictures: Pictures, least: float, progress: Callable[[], object]
) -> pd.DataFrame:
    """Detect in every picture: a row for each thing and for each detection that is none.

    Detections of all scores are kept, so that precision and recall follow at any threshold.

    Args:
        detector: Its least score should be near 0.
        pictures: Pictures with labels.
        least: Intersection over union from which on a thing of the class counts as found.
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
    """Pair the detections of a picture with its labels, the surest first, each label once.

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


def summary(rows: pd.DataFrame, threshold: float) -> dict[str, Any]:
    """Figures of a detector from its rows.

    Args:
        rows: As `judge` returns them.
        threshold: Least score for precision, recall and errors.

    Returns:
        map50 (mean over the classes of the average precision), precision and recall at the
        threshold, mean, 95th percentile and largest position error [mm], and the same by class.
    """
    by_class = {str(name): _figures(part, threshold) for name, part in rows.groupby("name")}
    whole = _figures(rows, threshold)
    whole["map50"] = float(np.mean([figures.pop("ap50") for figures in by_class.values()]))
    del whole["ap50"]
    for name, part in rows.groupby("name"):
        by_class[str(name)]["ap50"] = average_precision(part)
    return {**whole, "pictures": int(rows.picture.nunique()), "classes": by_class}


def average_precision(rows: pd.DataFrame) -> float:
    """Area under the precision-recall curve, precision made monotone (PASCAL VOC 2010 on).

    Args:
        rows: Of one class.
    """
    things = int((rows.kind != FALSE).sum())
    told = rows[rows.kind != MISSED].sort_values("score", ascending=False, kind="stable")
    hits = (told.kind == FOUND).to_numpy()
    if not things or not len(hits):
        return 0.0
    recall = np.cumsum(hits) / things
    precision = np.cumsum(hits) / np.arange(1, len(hits) + 1)
    envelope = np.maximum.accumulate(precision[::-1])[::-1]
    return float(np.sum(np.diff(recall, prepend=0.0) * envelope))


def _figures(rows: pd.DataFrame, threshold: float) -> dict[str, Any]:
    sure = rows[rows.score >= threshold]
    found = sure[sure.kind == FOUND]
    things = int((rows.kind != FALSE).sum())
    errors = 1e3 * found.error_m.to_numpy(dtype=float)
    some = len(errors) > 0
    return {
        "things": things,
        "precision": len(found) / max(len(sure), 1),
        "recall": len(found) / max(things, 1),
        "ap50": average_precision(rows),
        "position_error_mm": float(errors.mean()) if some else None,
        "position_error_p95_mm": float(np.percentile(errors, 95)) if some else None,
        "position_error_max_mm": float(errors.max()) if some else None,
    }
