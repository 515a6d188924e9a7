"""The study of what hardware must have been like, on trials whose chances are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

from benchmarks.hardware.chances import CLASSES, fit
from benchmarks.hardware.errors import ERRORS, values
from benchmarks.hardware.explanation import allowed, deviance, explain
from benchmarks.hardware.trials import design

Array = NDArray[np.float64]


def true_chances(shares: Array) -> Array:
    """Only the first error matters: it makes hands close on nothing."""
    lost = 1 / (1 + np.exp(4.0 - 8.0 * shares[:, 0]))
    return np.stack([(1 - lost) * 0.98, np.full(len(shares), 0.02) * (1 - lost), lost], axis=1)


def drawn(count: int) -> tuple[Array, NDArray[np.int64]]:
    shares, draw = design(count), np.random.default_rng(0)
    chances = true_chances(shares)
    outcomes = (draw.random((count, 1)) > np.cumsum(chances, axis=1)).sum(axis=1)
    return shares, outcomes


def test_scales_fall_by_factors_and_the_others_in_proportion() -> None:
    none, half = values(np.zeros(len(ERRORS))), values(np.full(len(ERRORS), 0.5))
    assert none["position_error"] == none["backlash"] == 0.0
    assert none["tension_scale"] == none["friction_scale"] == 1.0
    assert half["position_error"] == pytest.approx(0.015)
    assert half["tension_scale"] == pytest.approx(np.sqrt(0.1))


def test_a_longer_design_goes_on_from_a_shorter_one() -> None:
    assert np.array_equal(design(50), design(300)[:50])


def test_the_deviance_by_hand() -> None:
    """Two of three trials succeed with chance 1/2: 2 (2 ln(2/3 / 1/2) + ln(1/3 / 1/2))."""
    chances = np.array([[0.5, 0.5, 0.0]])
    expected = 2 * (2 * np.log(4 / 3) + np.log(2 / 3))
    assert deviance(chances, np.array([2.0, 1.0, 0.0]))[0] == pytest.approx(expected)


def test_the_deviance_is_zero_for_own_shares_and_chi_squared_for_the_truth() -> None:
    truth, draw = np.array([[0.75, 0.10, 0.15]]), np.random.default_rng(1)
    counts = draw.multinomial(94, truth[0], 4000).astype(float)
    assert deviance(counts[:1] / 94, counts[0])[0] == pytest.approx(0.0, abs=1e-9)
    found = np.array([deviance(truth, each)[0] for each in counts])
    assert np.mean(found > allowed()) == pytest.approx(0.05, abs=0.015)
    assert allowed() == chi2.ppf(0.95, 2)


def test_the_fit_finds_the_chances_that_trials_were_drawn_with() -> None:
    shares, outcomes = drawn(2000)
    model = fit(shares, outcomes)
    fresh = np.random.default_rng(3).random((500, len(ERRORS))) ** 2
    assert np.abs(model.of(fresh) - true_chances(fresh)).max() < 0.2
    assert np.abs(model.of(fresh) - true_chances(fresh)).mean() < 0.02
    assert model.gain > 0.1
    assert model.of(fresh).sum(axis=1) == pytest.approx(np.ones(500))


def test_errors_that_do_nothing_are_not_blamed() -> None:
    shares, outcomes = drawn(1000)
    counts = np.array([75.0, 2.0, 23.0])
    found = explain(shares, outcomes, np.arange(1000) % 100, counts)
    none, best = deviance(found.chances.of(np.stack([np.zeros(6), found.best])), counts)
    assert none > allowed() > best
    expected = 0.5 + np.log(0.23 / 0.77) / 8  # where 23 in 100 are lost
    assert found.best[0] == pytest.approx(expected, abs=0.06)
    assert found.alone[0].share < expected
    assert found.smallest[0] == pytest.approx(found.alone[0].share, abs=0.02)
    assert np.linalg.norm(found.smallest) <= found.alone[0].share + 1e-3
    assert found.smallest[1:] == pytest.approx(np.zeros(len(ERRORS) - 1), abs=0.07)
    assert found.explained == 1.0
    assert (found.spread[0] <= found.smallest + 0.05).all()
    assert all(np.isnan(each.share) for each in found.alone[1:])
    change = found.sensitivity(found.best)
    not_grasped = CLASSES.index("Not Grasped")
    assert change[0, not_grasped] > 0.05
    assert np.abs(change[1:, not_grasped]).max() < 0.5 * change[0, not_grasped]
    assert change.sum(axis=1) == pytest.approx(np.zeros(len(ERRORS)), abs=1e-12)


def test_counts_that_no_error_explains_say_so() -> None:
    shares, outcomes = drawn(500)
    found = explain(shares, outcomes, np.arange(500), np.array([20.0, 75.0, 5.0]))
    assert found.explained < 0.1
    assert np.isnan(found.smallest).all()
    assert np.isnan(found.ranges).all()
    assert deviance(found.chances.of(found.best[None]), found.counts)[0] > allowed()
    assert not found.likely
    assert found.best.shape == (len(ERRORS),)
