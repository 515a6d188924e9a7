"""The errors with which published counts of outcomes are likely, and the smallest of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaln, xlogy
from scipy.stats import chi2, qmc

from benchmarks.hardware.chances import Chances, fit
from benchmarks.hardware.errors import ERRORS

Array = NDArray[np.float64]
LEVEL = 0.95  # errors are refused whose chances the published counts contradict at this level
EVEN = 0.5  # level at which counts are as near to the chances as every other draw of them is
POINTS = 16  # power of two of the errors that are looked at
NEAR = 2.0  # more of them with small errors
GRID = 501  # shares of a single error
REFITS = 200  # of the chances, to drawn trials: how far the trials themselves leave it open
SEED = 6


def log_likelihood(chances: Array, counts: Array) -> Array:
    """Logarithm of the multinomial probability of counts (3,) under chances (N, 3)."""
    ways = gammaln(counts.sum() + 1) - gammaln(counts + 1).sum()
    result: Array = ways + xlogy(counts, np.maximum(chances, 1e-300)).sum(axis=1)
    return result


def deviance(chances: Array, counts: Array) -> Array:
    """Twice the logarithm by which the counts are less likely than under their own shares.

    Under the true chances it is distributed as chi-squared with two degrees of freedom, about.
    """
    own = log_likelihood((counts / counts.sum())[None], counts)
    result: Array = 2.0 * (own - log_likelihood(chances, counts))
    return result


@dataclass(frozen=True)
class Alone:
    """One error without the others.

    Attributes:
        share: The smallest that the counts do not contradict; not a number if they contradict all.
        best: The share with which the counts are most likely.
        deviance: With that.
    """

    share: float
    best: float
    deviance: float


@dataclass(frozen=True)
class Explanation:
    """What the counts say of the errors of a robot.

    Attributes:
        counts: (3,) published.
        chances: The model.
        none: Deviance without any error.
        smallest: (E,) shares of the errors that are smallest in the sum of their squares among
            those that the counts do not contradict; not numbers where they contradict all.
        spread: (2, E) between which 90 % of the smallest errors lie when the model is fitted to
            other draws of the trials.
        likely: (E,) the smallest with which the counts are as near to their chances as every
            other draw is; not numbers where there are none.
        least: Smallest deviance with any errors.
        ranges: (2, E) least and largest share of each error among those not contradicted, whatever
            the others are.
        alone: Each error without the others.
    """

    counts: Array
    chances: Chances
    none: float
    smallest: Array
    spread: Array
    likely: Array
    least: float
    ranges: Array
    alone: tuple[Alone, ...]

    def sensitivity(self, shares: Array) -> Array:
        """Change of each class's chance (E, 3) where an error grows by a tenth of its range."""
        steps = shares + 0.1 * np.eye(len(shares))
        change: Array = self.chances.of(steps) - self.chances.of(shares[None])
        return change


def allowed(level: float = LEVEL) -> float:
    """Largest deviance that counts of three classes do not contradict."""
    return float(chi2.ppf(level, 2))


def explain(shares: Array, outcomes: NDArray[np.int64], counts: Array) -> Explanation:
    """Find the errors that explain counts.

    Args:
        shares: (N, E) errors of the trials, shares of their ranges.
        outcomes: (N,) how they ended, places in `CLASSES`.
        counts: (3,) published.
    """
    model = fit(shares, outcomes)
    points = qmc.Sobol(len(ERRORS), rng=SEED).random_base2(POINTS) ** NEAR
    found = deviance(model.of(points), counts)
    inside = points[found <= allowed()]
    ranges = np.array([inside.min(axis=0), inside.max(axis=0)]) if len(inside) else _nothing(2)
    draw = np.random.default_rng(SEED)
    smallest = []
    for _ in range(REFITS):
        some = draw.integers(0, len(outcomes), len(outcomes))
        again = fit(shares[some], outcomes[some], model.penalty)
        smallest.append(_smallest(points, deviance(again.of(points), counts)))
    return Explanation(
        counts,
        model,
        float(deviance(model.of(np.zeros((1, len(ERRORS)))), counts)[0]),
        _smallest(points, found),
        np.nanquantile(smallest, (0.05, 0.95), axis=0),
        _smallest(points, found, EVEN),
        float(found.min()),
        ranges,
        tuple(_alone(model, counts, which) for which in range(len(ERRORS))),
    )


def _smallest(points: Array, found: Array, level: float = LEVEL) -> Array:
    """The point nearest to zero that is not contradicted at a level."""
    inside = points[found <= allowed(level)]
    if not len(inside):
        return _nothing(1)[0]
    smallest: Array = inside[np.argmin((inside**2).sum(axis=1))]
    return smallest


def _nothing(lines: int) -> Array:
    return np.full((lines, len(ERRORS)), np.nan)


def _alone(model: Chances, counts: Array, which: int) -> Alone:
    grid = np.linspace(0.0, 1.0, GRID)
    shares = np.zeros((GRID, len(ERRORS)))
    shares[:, which] = grid
    found = deviance(model.of(shares), counts)
    inside = found <= allowed()
    best = int(np.argmin(found))
    first = float(grid[inside.argmax()]) if inside.any() else np.nan
    return Alone(first, float(grid[best]), float(found[best]))
