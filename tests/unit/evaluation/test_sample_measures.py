"""Measures of many solutions of one pose, on sets where they are known by hand."""

from __future__ import annotations

import math

import numpy as np
import pandas as pd
import pytest

from pipeline.evaluation.sample_measures import (
    KERNEL_WIDTH,
    RADIUS,
    best_of,
    by_pose,
    clusters,
    coverage,
    squared_discrepancy,
)

CORNERS = np.array([[0.0, 0.0], [0.0, 2.0], [2.0, 0.0], [2.0, 2.0]])


def test_clusters_are_no_wider_than_the_radius() -> None:
    rng = np.random.default_rng(0)
    near = np.repeat(CORNERS, 10, axis=0) + rng.uniform(-0.1, 0.1, (40, 2))
    labels = clusters(near)
    assert len(set(labels)) == 4
    assert all(len(set(labels[i : i + 10])) == 1 for i in range(0, 40, 10))
    line = np.linspace(0, 3, 200)[:, None]
    pieces = clusters(line)
    widths = [np.ptp(line[pieces == piece]) for piece in np.unique(pieces)]
    assert max(widths) <= RADIUS
    assert 10 <= len(widths) <= 20
    assert clusters(line[:1]).tolist() == [1] and clusters(line[:0]).tolist() == []


def test_coverage_is_the_share_of_clusters_that_are_hit() -> None:
    solutions = np.repeat(CORNERS, 3, axis=0)
    drawn = np.array([[0.1, -0.2], [2.0, 2.29], [1.0, 1.0], [0.31, 2.0]])
    assert coverage(drawn, solutions) == 0.5
    assert coverage(CORNERS, solutions) == 1
    assert math.isnan(coverage(drawn, solutions[:0])) and coverage(drawn[:0], solutions) == 0


def test_discrepancy_of_two_points_each_by_hand() -> None:
    """Kernel of points a distance d apart is exp(-d² / 2 w²)."""
    first, second = np.array([[0.0], [1.0]]), np.array([[0.0], [2.0]])

    def kernel(distance: float) -> float:
        return math.exp(-(distance**2) / (2 * KERNEL_WIDTH**2))

    cross = (kernel(0) + kernel(2) + kernel(1) + kernel(1)) / 4
    expected = kernel(1) + kernel(2) - 2 * cross
    assert squared_discrepancy(first, second) == pytest.approx(expected)
    rng = np.random.default_rng(1)
    same = [squared_discrepancy(*rng.normal(size=(2, 60, 3))) for _ in range(40)]
    assert abs(np.mean(same)) < 3 * np.std(same) / math.sqrt(40), "unbiased where they are alike"
    assert squared_discrepancy(rng.normal(size=(60, 3)), rng.normal(3, 1, size=(60, 3))) > 0.05
    assert math.isnan(squared_discrepancy(first[:1], second))


def test_the_best_of_some_draws_is_the_best_by_both_errors() -> None:
    rows = pd.DataFrame({"pose": [0, 0, 0, 1, 1, 1], "sample": [0, 1, 2] * 2})
    rows["position_error_mm"] = [10.0, 1, 0.1, 5, 4, 3]
    rows["rotation_error_deg"] = [1.0, 90, 1, 2, 1, 9]
    assert best_of(rows, 1).position_error_mm.tolist() == [10, 5]
    assert best_of(rows, 2).position_error_mm.tolist() == [10, 4]
    assert best_of(rows, 3).position_error_mm.tolist() == [0.1, 4]


def test_references_that_were_not_found_or_restarted_do_not_count() -> None:
    drawn = pd.DataFrame({"pose": [0, 0, 1, 1], "q0": [0.0, 1.0, 0.0, 0.1]})
    drawn["starts"] = [1, 2, 0, 0]
    references = pd.DataFrame({"pose": [0, 0, 0, 0, 1], "q0": [0.0, 1.0, 5.0, 9.0, 0.0]})
    references["found"] = [True, True, False, True, False]
    references["starts"] = [1, 1, 9, 2, 9]
    measured = by_pose(drawn, references)
    assert measured.coverage[0] == 0.5 and math.isnan(measured.coverage[1])
    assert measured.clusters.tolist() == [2, 0]
