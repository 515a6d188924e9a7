"""Statistics against closed forms, sampling theory and numbers worked out by hand."""

from math import comb
from statistics import NormalDist

import numpy as np
import pytest
from scipy import stats

from pipeline.evaluation import statistics
from pipeline.evaluation.statistics import (
    StatisticsError,
    bootstrap_interval,
    holm,
    mcnemar,
    wilcoxon,
    wilson_interval,
)


@pytest.mark.parametrize(("successes", "trials"), [(0, 10), (10, 10), (7, 10), (4999, 5000)])
def test_wilson_is_the_closed_form(successes, trials):
    found = wilson_interval(successes, trials, 0.95)
    z, rate = NormalDist().inv_cdf(0.975), successes / trials
    centre = (rate + z**2 / (2 * trials)) / (1 + z**2 / trials)
    root = np.sqrt(rate * (1 - rate) / trials + z**2 / (4 * trials**2))
    half = z / (1 + z**2 / trials) * root
    assert (found.low, found.high) == pytest.approx((centre - half, centre + half), abs=1e-12)
    assert 0 <= found.low <= found.estimate <= found.high <= 1


def test_wilson_without_trials_knows_nothing():
    interval = wilson_interval(0, 0, 0.95)
    assert np.isnan(interval.estimate)
    assert (interval.low, interval.high) == (0.0, 1.0)


@pytest.mark.parametrize("statistic", [np.mean, np.median])
def test_bootstrap_takes_quantiles_of_what_is_drawn_with_replacement(statistic):
    sample = np.random.default_rng(5).lognormal(size=300)
    found = bootstrap_interval(sample, statistic, 0.9, 4000, seed=1)
    generator = np.random.default_rng(2)  # other draws
    drawn = [statistic(generator.choice(sample, sample.size)) for _ in range(4000)]
    low, high = np.quantile(drawn, [0.05, 0.95])
    assert found.estimate == pytest.approx(statistic(sample))
    assert abs(found.low - low) < 0.1 * (high - low)
    assert abs(found.high - high) < 0.1 * (high - low)


def test_bootstrap_of_one_value_is_that_value():
    interval = bootstrap_interval([3.0, np.nan], np.mean, 0.95, 100, seed=0)
    assert (interval.estimate, interval.low, interval.high) == (3.0, 3.0, 3.0)


def test_bootstrap_in_blocks_is_the_bootstrap_at_once(monkeypatch):
    sample = np.random.default_rng(6).normal(size=50)
    whole = bootstrap_interval(sample, np.mean, 0.95, 200, seed=4)
    monkeypatch.setattr(statistics, "BLOCK_VALUES", 50 * 7)
    blocks = bootstrap_interval(sample, np.mean, 0.95, 200, seed=4)
    assert (blocks.low, blocks.high) == pytest.approx((whole.low, whole.high), rel=1e-12)


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


def test_mcnemar_exact_is_the_tail_of_the_binomial_distribution():
    first = np.array([True] * 12 + [False] * 3 + [True] * 40 + [False] * 5)
    second = np.array([False] * 12 + [True] * 3 + [True] * 40 + [False] * 5)
    result = mcnemar(first, second)
    assert result.effect == pytest.approx(9 / 60)
    assert result.pairs == 15
    assert result.p_value == pytest.approx(2 * sum(comb(15, k) for k in range(4)) / 2**15)


def test_mcnemar_of_equals_and_of_many():
    same = np.ones(10, dtype=bool)
    assert mcnemar(same, same).p_value == 1.0
    first = np.array([True] * 900 + [False] * 800)
    result = mcnemar(first, ~first)
    assert result.p_value == pytest.approx(stats.chi2.sf((100 - 1) ** 2 / 1700, 1), rel=1e-9)


def test_wilcoxon_is_the_normal_approximation_with_ties_and_zeros():
    generator = np.random.default_rng(7)
    first = generator.integers(0, 30, 200).astype(float)
    second = first + generator.integers(-3, 5, 200)
    ours = wilcoxon(np.append(first, np.nan), np.append(second, 1.0))
    unequal = (first - second)[first != second]
    n = len(unequal)
    ranks = stats.rankdata(np.abs(unequal))
    ties = np.unique(ranks, return_counts=True)[1]
    variance = n * (n + 1) * (2 * n + 1) / 24 - (ties**3 - ties).sum() / 48
    score = (ranks[unequal > 0].sum() - n * (n + 1) / 4) / np.sqrt(variance)
    assert ours.p_value == pytest.approx(2 * NormalDist().cdf(-abs(score)), rel=1e-9)
    assert ours.effect == np.median(first - second)
    assert ours.pairs == n
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
