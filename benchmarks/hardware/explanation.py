"""The errors with which published counts of outcomes are likely, and the smallest of them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import NonlinearConstraint, minimize
from scipy.special import xlogy
from scipy.stats import chi2, qmc

from benchmarks.hardware.chances import Chances, fit
from benchmarks.hardware.errors import ERRORS

Array = NDArray[np.float64]
LEVEL = 0.95  # errors are refused whose chances the published counts contradict at this level
EVEN = 0.5  # level at which half of all draws of the counts would be farther off
POINTS = 14  # power of two of the errors that are looked at
NEAR = 2.0  # more of them with small errors
GRID = 501  # shares of a single error
REFITS = 200  # of the chances, to drawn trials: how far the trials themselves leave it open
SEED = 6
SMALL = 1e-3  # share below which an error is none, and deviance that a search may be off by


def deviance(chances: Array, counts: Array) -> Array:
    """Twice the logarithm by which counts (3,) are less likely than under their own shares.

    Under the true chances it is distributed as chi-squared with two degrees of freedom, about.

    Args:
        chances: (N, 3).
        counts: (3,).
    """
    own = xlogy(counts, counts / counts.sum())
    result: Array = 2.0 * (own - xlogy(counts, np.maximum(chances, 1e-300))).sum(axis=1)
    return result


@dataclass(frozen=True)
class Alone:
    """One error without the others.

    Attributes:
        share: The smallest that the counts do not contradict; not a number if they contradict all.
        deviance: The least that any share of it has.
    """

    share: float
    deviance: float


@dataclass(frozen=True)
class Explanation:
    """What the counts say of the errors of a robot, if the fitted chances are the true ones.

    Attributes:
        counts: (3,) published.
        chances: The model.
        smallest: (E,) shares of the errors that are smallest in the sum of their squares among
            those that the counts do not contradict; not numbers where they contradict all.
        spread: (2, E) between which 90 % of the smallest errors lie when the model is fitted to
            other draws of the placements.
        explained: Share of these fits that explain the counts at all.
        likely: Whether any errors make the counts likely: half of all draws would be farther off.
        best: (E,) the smallest of those, or else the errors with the least deviance.
        ranges: (2, E) least and largest share of each error among those not contradicted, whatever
            the others are.
        alone: Each error without the others.
    """

    counts: Array
    chances: Chances
    smallest: Array
    spread: Array
    explained: float
    likely: bool
    best: Array
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


def explain(
    shares: Array, outcomes: NDArray[np.int64], places: NDArray[np.int64], counts: Array
) -> Explanation:
    """Find the errors that explain counts.

    Args:
        shares: (N, E) errors of the trials, shares of their ranges.
        outcomes: (N,) how they ended, places in `CLASSES`.
        places: (N,) number of the placement that each began with; some begin alike.
        counts: (3,) published.
    """
    model = fit(shares, outcomes)
    points = _candidates()
    found = deviance(model.of(points), counts)
    inside, likely = points[found <= allowed()], _smallest(model, counts, EVEN)
    nothing = bool(np.isnan(likely).any())
    ranges = np.array([inside.min(axis=0), inside.max(axis=0)]) if len(inside) else _nothing(2)
    smallest = _refitted(shares, outcomes, places, counts, model.penalty)
    explained = ~np.isnan(smallest[:, 0])
    return Explanation(
        counts,
        model,
        _smallest(model, counts),
        np.quantile(smallest[explained], (0.05, 0.95), axis=0) if any(explained) else _nothing(2),
        float(explained.mean()),
        not nothing,
        points[np.argmin(found)] if nothing else likely,
        ranges,
        tuple(_alone(model, counts, which) for which in range(len(ERRORS))),
    )


@cache
def _candidates() -> Array:
    """Shares to look at (N, E): none, each error alone, and many at once."""
    many = qmc.Sobol(len(ERRORS), rng=SEED).random_base2(POINTS) ** NEAR
    alone = [share * axis for axis in np.eye(len(ERRORS)) for share in np.linspace(0.0, 1.0, 51)]
    return np.concatenate((alone, many))


def _refitted(
    shares: Array,
    outcomes: NDArray[np.int64],
    places: NDArray[np.int64],
    counts: Array,
    penalty: float,
) -> Array:
    """Smallest errors (`REFITS`, E) by models of placements drawn with replacement."""
    draw = np.random.default_rng(SEED)
    rows = [np.flatnonzero(places == place) for place in np.unique(places)]
    smallest = []
    for _ in range(REFITS):
        some = np.concatenate([rows[k] for k in draw.integers(0, len(rows), len(rows))])
        smallest.append(_smallest(fit(shares[some], outcomes[some], penalty), counts))
    return np.array(smallest)


def _smallest(model: Chances, counts: Array, level: float = LEVEL) -> Array:
    """The errors nearest to zero that are not contradicted at a level."""
    points = _candidates()
    inside = points[deviance(model.of(points), counts) <= allowed(level)]
    if not len(inside):
        return _nothing(1)[0]
    start: Array = inside[np.argmin((inside**2).sum(axis=1))]
    if not start.any():
        return start

    def excess(shares: Array) -> float:
        return float(deviance(model.of(shares[None]), counts)[0])

    found = minimize(
        lambda shares: (float(shares @ shares), 2.0 * shares),
        start,
        jac=True,
        method="SLSQP",
        bounds=[(0.0, 1.0)] * len(start),
        constraints=NonlinearConstraint(excess, -np.inf, allowed(level)),
    )
    polished: Array = np.where(found.x < SMALL, 0.0, found.x)
    nearer = polished @ polished < start @ start
    return polished if nearer and excess(polished) <= allowed(level) + SMALL else start


def _nothing(lines: int) -> Array:
    return np.full((lines, len(ERRORS)), np.nan)


def _alone(model: Chances, counts: Array, which: int) -> Alone:
    grid = np.linspace(0.0, 1.0, GRID)
    shares = np.zeros((GRID, len(ERRORS)))
    shares[:, which] = grid
    found = deviance(model.of(shares), counts)
    inside = found <= allowed()
    first = float(grid[inside.argmax()]) if inside.any() else np.nan
    return Alone(first, float(found.min()))
