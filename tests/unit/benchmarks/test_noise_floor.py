"""The noise floor by hand: trials that always, never and now and then succeed."""

from __future__ import annotations

from argparse import Namespace

import pandas as pd
import pytest

from benchmarks.noise_floor import disagreement, overrides, rates_of, tables
from pipeline.config import compose
from pipeline.grasping.ablation import variants


def rows_of(rate: float, *trials: str) -> pd.DataFrame:
    """Rows of NICO at a rate: a text a trial, with a digit a seed, 1 for a success."""
    lines = [
        {
            "robot": "nico",
            "rate_hz": rate,
            "noise_seed": seed,
            "trial": trial,
            "class": "Success" if digit == "1" else "Slipped",
            "wall_s": 3.0,
        }
        for trial, digits in enumerate(trials)
        for seed, digit in enumerate(digits)
    ]
    return pd.DataFrame(lines)


def test_two_seeds_differ_as_often_as_pairs_that_are_counted() -> None:
    (line,) = rates_of(rows_of(240.0, "1111", "0000", "1100", "1110"))
    # Pairs of four seeds: 6 a trial; 0, 0, 4 and 3 of them differ.
    assert disagreement(line, line) == pytest.approx((4 / 6 + 3 / 6) / 4)
    assert (line.undecided, line.by_seed.min(), line.by_seed.max()) == (2, 0.25, 0.75)


def test_two_rates_differ_as_often_as_pairs_that_are_counted() -> None:
    first, second = rates_of(pd.concat([rows_of(120.0, "10", "11"), rows_of(240.0, "00", "01")]))
    # Pairs of a seed here and a seed there: 4 a trial; 2 and 2 of them differ.
    assert disagreement(first, second) == pytest.approx(0.5)
    assert pd.isna(disagreement(*[*rates_of(rows_of(120.0, "1"))] * 2))


def test_trials_that_lack_a_seed_are_left_out() -> None:
    rows = rows_of(240.0, "11", "10").iloc[:-1]
    (line,) = rates_of(rows)
    assert [*line.success.index] == [0]
    whole, pairs = (table.records() for table in tables(rows))
    assert (whole[0]["trials"], whole[0]["always"], whole[0]["undecided"]) == (1, 1, 0)
    assert pairs == [{"robot": "NICO", "rates": "240, 240", "disagreement": 0.0}]


def test_the_study_varies_seeds_and_rates_on_pinned_trials() -> None:
    options = Namespace(trials=5, seeds=2, rates=[120.0, 480.0], overrides=[])
    grasp = compose(overrides("nico", options)).grasp
    assert [*variants(grasp)] == [
        {"noise_seed": seed, "rate": rate} for seed in (0, 1) for rate in (120.0, 480.0)
    ]
    assert grasp.physics.placement_noise == 1e-6
    assert (grasp.placements, grasp.trials) == ("pinned", 5)
