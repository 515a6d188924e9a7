"""Statistics against SciPy and against numbers worked out by hand."""

import numpy as np
import pytest
from scipy import stats

from pipeline.evaluation.statistics import (
    StatisticsError,
    bootstrap_interval,
    holm,
    mcnemar,
    wilcoxon,
    wilson_interval,
)


@pytest.mark.parametrize(("successes", "trials"), [(0, 10), (10, 10), (7, 10), (4999, 5000)])
def test_wilson_agrees_with_scipy(successes, trials):
    ours = wilson_interval(successes, trials, 0.95)
    theirs = stats.binomtest(successes, trials).proportion_ci(0.95, method="wilson")
    assert (ours.low, ours.high) == pytest.approx((theirs.low, theirs.high), abs=1e-12)
    assert ours.low <= ours.estimate <= ours.high


def test_wilson_without_trials_knows_nothing():
    interval = wilson_interval(0, 0, 0.95)
    assert np.isnan(interval.estimate)
    assert (interval.low, interval.high) == (0.0, 1.0)


@pytest.mark.parametrize("statistic", [np.mean, np.median])
def test_bootstrap_agrees_with_scipy(statistic):
    sample = np.random.default_rng(5).lognormal(size=300)
    ours = bootstrap_interval(sample, statistic, 0.9, 4000, seed=1)
    theirs = stats.bootstrap(
        (sample,), statistic, n_resamples=4000, confidence_level=0.9, method="percentile", rng=2
    ).confidence_interval
    width = theirs.high - theirs.low
    assert ours.estimate == pytest.approx(statistic(sample))
    assert abs(ours.low - theirs.low) < 0.1 * width
    assert abs(ours.high - theirs.high) < 0.1 * width


def test_bootstrap_is_the_same_for_the_same_seed_and_leaves_nan_out():
    sample = np.array([1.0, 2.0, np.nan, 4.0])
    first = bootstrap_interval(sample, np.mean, 0.95, 200, seed=3)
    assert first == bootstrap_interval([1.0, 2.0, 4.0], np.mean, 0.95, 200, seed=3)
    assert np.isnan(bootstrap_interval([np.nan], np.mean, 0.95, 200, seed=3).estimate)


def test_bootstrap_covers_the_mean_about_as_often_as_it_says():
    generator = np.random.default_rng(0)
    hits = 0
    for seed in range(200):
        interval = bootstrap_interval(generator.normal(size=60), np.mean, 0.9, 300, seed)
        hits += interval.low <= 0 <= interval.high
    assert 0.83 <= hits / 200 <= 0.96


def test_mcnemar_exact_agrees_with_the_binomial_test():
    first = np.array([True] * 12 + [False] * 3 + [True] * 40 + [False] * 5)
    second = np.array([False] * 12 + [True] * 3 + [True] * 40 + [False] * 5)
    result = mcnemar(first, second)
    assert result.effect == pytest.approx(9 / 60)
    assert result.pairs == 15
    assert result.p_value == pytest.approx(stats.binomtest(3, 15).pvalue)


def test_mcnemar_of_equals_and_of_many():
    same = np.ones(10, dtype=bool)
    assert mcnemar(same, same).p_value == 1.0
    first = np.array([True] * 900 + [False] * 800)
    result = mcnemar(first, ~first)
    assert result.p_value == pytest.approx(stats.chi2.sf((100 - 1) ** 2 / 1700, 1), rel=1e-9)


def test_wilcoxon_agrees_with_scipy_with_ties_and_zeros():
    generator = np.random.default_rng(7)
    first = generator.integers(0, 30, 200).astype(float)
    second = first + generator.integers(-3, 5, 200)
    ours = wilcoxon(first, second)
    theirs = stats.wilcoxon(first, second, correction=False, method="asymptotic")
    assert ours.p_value == pytest.approx(theirs.pvalue, rel=1e-9)
    assert ours.effect == np.median(first - second)
    assert wilcoxon(first, first).p_value == 1.0


def test_holm_by_hand():
    adjusted = holm({"a": 0.01, "b": 0.04, "c": 0.03, "d": 0.005})
    assert adjusted == pytest.approx({"a": 0.03, "b": 0.06, "c": 0.06, "d": 0.02})


def test_impossible_requests_are_refused():
    with pytest.raises(StatisticsError, match="successes"):
        wilson_interval(3, 2, 0.95)
    with pytest.raises(StatisticsError, match="confidence"):
        wilson_interval(1, 2, 1.0)
    with pytest.raises(StatisticsError, match="resample"):
        bootstrap_interval([1.0], np.mean, 0.95, 0, seed=0)
    with pytest.raises(StatisticsError, match="equally long"):
        mcnemar([True], [True, False])
