"""Figures of a detector from its raw rows alone: precision, recall, mAP50, position errors."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

FOUND, MISSED, FALSE = "found", "missed", "false"  # what a raw row is of


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
    objects = int((rows.kind != FALSE).sum())
    detected = rows[rows.kind != MISSED].sort_values("score", ascending=False, kind="stable")
    hits = (detected.kind == FOUND).to_numpy()
    if not objects or not len(hits):
        return 0.0
    recall = np.cumsum(hits) / objects
    precision = np.cumsum(hits) / np.arange(1, len(hits) + 1)
    envelope = np.maximum.accumulate(precision[::-1])[::-1]
    return float(np.sum(np.diff(recall, prepend=0.0) * envelope))


def _figures(rows: pd.DataFrame, threshold: float) -> dict[str, Any]:
    sure = rows[(rows.kind != MISSED) & (rows.score >= threshold)]
    found = sure[sure.kind == FOUND]
    objects = int((rows.kind != FALSE).sum())
    errors = 1e3 * found.error_m.to_numpy(dtype=float)
    some = len(errors) > 0
    return {
        "objects": objects,
        "precision": len(found) / max(len(sure), 1),
        "recall": len(found) / max(objects, 1),
        "ap50": average_precision(rows),
        "position_error_mm": float(errors.mean()) if some else None,
        "position_error_p95_mm": float(np.percentile(errors, 95)) if some else None,
        "position_error_max_mm": float(errors.max()) if some else None,
    }
