"""How sure a number is: intervals of rates and means, and paired comparisons of two solvers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

from pipeline.errors import PipelineError

BLOCK_VALUES = 4_000_000  # values resampled at a time: bounds the memory of a bootstrap
EXACT_DISCORDANT = 1000  # up to here McNemar's test is the exact binomial one


class StatisticsError(PipelineError):
    """Data or settings that a statistic is not defined for."""


@dataclass(frozen=True)
class Interval:
    """An estimate with the bounds of its confidence interval, all in the unit of the data."""

    estimate: float
    low: float
    high: float


@dataclass(frozen=True)
class Comparison:
    """Two solvers on the same poses: the effect first, then how surprising it would be.

    Attributes:
        effect: A minus B, in the unit of what was compared (a share for McNemar).
        p_value: Two-sided.
        pairs: Pairs that the test rests on (discordant, or of unequal values).
    """

    effect: float
    p_value: float
    pairs: int


def wilson_interval(successes: int, trials: int, confidence: float) -> Interval:
    """Confidence interval of a rate that holds near 0 and 1 too.

    Wilson (1927), "Probable inference, the law of succession, and statistical inference".

    Args:
        successes: Trials that succeeded.
        trials: All trials; with none the rate is NaN and the interval is [0, 1].
        confidence: For example 0.95.

    Raises:
        StatisticsError: Counts that are not possible, or a confidence outside (0, 1).
    """
    if not 0 <= successes <= trials:
        raise StatisticsError(f"expected 0 <= successes <= trials, got {successes} of {trials}")
    if trials == 0:
        return Interval(float("nan"), 0.0, 1.0)
    test = stats.binomtest(successes, trials)
    interval = test.proportion_ci(_checked_confidence(confidence), method="wilson")
    # At the ends the closed form is exact but for rounding, which must not leave [0, 1].
    low = 0.0 if successes == 0 else float(interval.low)
    high = 1.0 if successes == trials else float(interval.high)
    return Interval(successes / trials, low, high)


def bootstrap_interval(
    values: ArrayLike,
    statistic: Callable[..., ArrayLike],
    confidence: float,
    resamples: int,
    seed: int,
) -> Interval:
    """Percentile bootstrap interval of a statistic of one sample (Efron & Tibshirani, ch. 13).

    Args:
        values: (N,) values; NaN is left out, as a pose without a value.
        statistic: Takes an array and ``axis``, for example ``np.mean``.
        confidence: For example 0.95.
        resamples: Samples drawn with replacement.
        seed: Seed of the draws; equal seeds give equal intervals.

    Raises:
        StatisticsError: No resamples, or a confidence outside (0, 1).
    """
    if resamples < 1:
        raise StatisticsError(f"expected at least 1 resample, got {resamples}")
    _checked_confidence(confidence)
    sample = np.asarray(values, dtype=np.float64)
    sample = sample[~np.isnan(sample)]
    if sample.size == 0:
        return Interval(float("nan"), float("nan"), float("nan"))
    estimate = float(np.asarray(statistic(sample, axis=-1)))
    if sample.size == 1 or resamples == 1:  # SciPy wants two of both
        return Interval(estimate, estimate, estimate)
    found = stats.bootstrap(
        (sample,),
        statistic,
        n_resamples=resamples,
        batch=max(BLOCK_VALUES // sample.size, 1),
        vectorized=True,
        confidence_level=confidence,
        method="percentile",
        rng=np.random.default_rng(seed),
    ).confidence_interval
    return Interval(estimate, float(found.low), float(found.high))


def shifted_geometric_mean(values: ArrayLike, shift: float, axis: int = -1) -> Any:
    """Return exp(mean(ln(x + s))) - s, which neither the slowest calls nor the fastest rule.

    Achterberg (2007), "Constraint Integer Programming", section A.3.

    Args:
        values: (..., N) not negative.
        shift: s, in the unit of the values.
        axis: Along which values are averaged.
    """
    return np.exp(np.mean(np.log(np.asarray(values) + shift), axis=axis)) - shift


def mcnemar(first: ArrayLike, second: ArrayLike) -> Comparison:
    """Compare two rates on the same poses by the poses on which they differ (McNemar, 1947).

    Exact (binomial) for up to 1,000 discordant poses, then the chi-square approximation with
    continuity correction.

    Args:
        first: (N,) success of A.
        second: (N,) success of B on the same poses.
    """
    a, b = _paired(np.asarray(first, dtype=bool), np.asarray(second, dtype=bool))
    only_a, only_b = int((a & ~b).sum()), int((b & ~a).sum())
    discordant = only_a + only_b
    effect = (only_a - only_b) / len(a)
    if discordant == 0:
        return Comparison(effect, 1.0, 0)
    if discordant <= EXACT_DISCORDANT:
        p_value = stats.binomtest(only_a, discordant).pvalue
        return Comparison(effect, float(p_value), discordant)
    score = max(abs(only_a - only_b) - 1, 0) / sqrt(discordant)
    return Comparison(effect, float(2 * stats.norm.sf(score)), discordant)


def wilcoxon(first: ArrayLike, second: ArrayLike) -> Comparison:
    """Wilcoxon's signed-rank test on the same poses, normal approximation with ties.

    The effect is the median of the differences A - B. Pairs without a difference are left out
    (Wilcoxon, 1945); equal differences share their mean rank.

    Args:
        first: (N,) errors of A.
        second: (N,) errors of B on the same poses; pairs with NaN are left out.
    """
    a, b = _paired(np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64))
    difference = (a - b)[~np.isnan(a - b)]
    effect = float(np.median(difference)) if difference.size else float("nan")
    count = int(np.count_nonzero(difference))
    if count == 0:
        return Comparison(effect, 1.0, 0)
    test = stats.wilcoxon(difference, method="asymptotic", correction=False)
    return Comparison(effect, float(test.pvalue), count)


def holm(p_values: Mapping[str, float]) -> dict[str, float]:
    """Adjust p-values of several comparisons so that they may be read side by side (Holm, 1979).

    Args:
        p_values: One for each comparison.

    Returns:
        Adjusted p-values under the same names, at most 1.
    """
    adjusted: dict[str, float] = {}
    largest = 0.0
    for rank, name in enumerate(sorted(p_values, key=lambda name: p_values[name])):
        largest = max(largest, min(1.0, (len(p_values) - rank) * p_values[name]))
        adjusted[name] = largest
    return {name: adjusted[name] for name in p_values}


def _paired(a: NDArray[Any], b: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    if a.shape != b.shape or a.ndim != 1 or a.size == 0:
        raise StatisticsError(
            f"expected two equally long, non-empty rows, got {a.shape}, {b.shape}"
        )
    return a, b


def _checked_confidence(confidence: float) -> float:
    if not 0 < confidence < 1:
        raise StatisticsError(f"expected a confidence between 0 and 1, got {confidence}")
    return confidence
