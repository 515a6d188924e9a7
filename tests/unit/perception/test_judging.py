"""How detections are held against labels, with numbers computed by hand."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from pipeline.evaluation.detections import average_precision, summary
from pipeline.perception.detection import Detection
from pipeline.perception.judging import match
from pipeline.perception.pinhole import Pinhole
from pipeline.perception.studio import Label

# One metre above the table, looking straight down: 500 pixels are a metre.
DOWN = np.array([[0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 1], [0, 0, 0, 1]], dtype=float)
CAMERA = Pinhole(DOWN, 500.0, 640, 480)
BOX = (300.0, 220.0, 340.0, 260.0)
TRUE = Label("pear", BOX, (320.0, 240.0), (0.0, 0.0, 0.0))


def seen(name: str = "pear", score: float = 0.9, u: float = 320.0, v: float = 240.0) -> Detection:
    return Detection(name, score, (u - 20, v - 20, u + 20, v + 20), (u, v))


def rows(*found: Detection, labels: list[Label] | None = None) -> pd.DataFrame:
    return pd.DataFrame(match(found, labels or [TRUE], CAMERA, 0.5))


def test_a_found_object_has_its_error_in_metres_and_pixels() -> None:
    (row,) = rows(seen(u=323.0, v=236.0)).to_dict("records")
    assert (row["kind"], row["name"]) == ("found", "pear")
    assert row["pixel_error"] == pytest.approx(5.0)
    assert row["error_m"] == pytest.approx(0.01)
    # Up in the picture is ahead (x), left is left (y).
    assert (row["seen_x_m"], row["seen_y_m"]) == pytest.approx((0.008, -0.006))


def test_another_class_a_far_box_and_a_second_box_are_false() -> None:
    detected = rows(seen("orange"), seen(u=400.0), seen(score=0.8), seen(score=0.7))
    assert sorted(detected.kind) == ["false", "false", "false", "found"]
    assert detected[detected.kind == "found"].score.item() == 0.8
    assert sorted(rows(seen("orange")).kind) == ["false", "missed"]


def test_a_centroid_that_looks_at_the_sky_has_no_place() -> None:
    level = Pinhole(np.eye(4) + np.eye(4, k=3) * 0.0, 500.0, 640, 480)
    found = Detection("pear", 0.9, BOX, (320.0, 100.0))
    (row,) = match([found], [TRUE], level, 0.5)
    assert row["kind"] == "found" and np.isnan(row["error_m"])


def test_average_precision_by_hand() -> None:
    detected = pd.DataFrame(
        {
            "kind": ["found", "false", "found", "missed"],
            "score": [0.9, 0.8, 0.7, 0.0],
        }
    )
    # Three objects: precision 1 up to a recall of 1/3, then 2/3 up to 2/3, then nothing.
    assert average_precision(detected) == pytest.approx(1 / 3 + 2 / 3 * 1 / 3)
    assert average_precision(detected[detected.kind == "missed"]) == 0.0
    assert average_precision(detected[:1]) == 1.0


def test_a_summary_counts_only_what_is_sure_enough() -> None:
    detected = rows(seen(score=0.2), seen("orange", 0.9)).assign(picture=0)
    low, high = summary(detected, 0.1), summary(detected, 0.5)
    assert (low["precision"], low["recall"]) == (0.5, 1.0)
    assert (high["precision"], high["recall"]) == (0.0, 0.0)
    assert high["position_error_mm"] is None
    assert low["map50"] == pytest.approx(0.5)  # of the pear 1, of the orange that is not there 0
    assert low["classes"]["pear"]["ap50"] == 1.0
