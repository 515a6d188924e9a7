"""Chances of the outcomes of a trial as a function of its errors, fitted to trials.

Multinomial logistic regression: the logarithm of a class's chance against that of a success is
linear in the errors' shares and their squares. Its coefficients are drawn towards zero by a
penalty, whose weight is chosen by cross-validation.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import log_softmax, softmax

from pipeline.grasping.outcome import NOT_GRASPED, SLIPPED, SUCCESS

Array = NDArray[np.float64]
CLASSES = (SUCCESS, SLIPPED, NOT_GRASPED)
PENALTIES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0)
FOLDS = 10


@dataclass(frozen=True)
class Chances:
    """A fitted model.

    Attributes:
        weights: (1 + 2 E, 2) of the two classes that are not a success.
        penalty: Of the squares of all weights but the first line's.
        gain: Nats that a trial's class is better foretold than by the classes' frequencies, on
            trials that the fit has not seen.
    """

    weights: Array
    penalty: float
    gain: float

    def of(self, shares: Array) -> Array:
        """Chances (N, 3) of the classes with errors of shares (N, E)."""
        chances: Array = softmax(_scores(self.weights, shares), axis=1)
        return chances


def fit(shares: Array, outcomes: NDArray[np.int64], penalty: float | None = None) -> Chances:
    """Fit chances to trials.

    Args:
        shares: (N, E) of the errors' ranges.
        outcomes: (N,) place in `CLASSES`.
        penalty: If it is known already; else that of `PENALTIES` which foretells best.
    """
    if penalty is not None:
        return Chances(_fitted(shares, outcomes, penalty), penalty, np.nan)
    folds = np.arange(len(outcomes)) % FOLDS
    losses = [
        np.mean([_held_out(shares, outcomes, folds == fold, each) for fold in range(FOLDS)])
        for each in PENALTIES
    ]
    best = int(np.argmin(losses))
    frequency = np.bincount(outcomes, minlength=len(CLASSES)) / len(outcomes)
    blind = -np.mean(np.log(frequency[outcomes]))
    return Chances(
        _fitted(shares, outcomes, PENALTIES[best]), PENALTIES[best], float(blind - losses[best])
    )


def _features(shares: Array) -> Array:
    return np.concatenate((np.ones((len(shares), 1)), shares, shares**2), axis=1)


def _scores(weights: Array, shares: Array) -> Array:
    others = _features(shares) @ weights
    return np.concatenate((np.zeros((len(shares), 1)), others), axis=1)


def _held_out(
    shares: Array, outcomes: NDArray[np.int64], out: NDArray[np.bool_], penalty: float
) -> float:
    """Mean loss on the trials that are left out of a fit [nat]."""
    weights = _fitted(shares[~out], outcomes[~out], penalty)
    logarithms = log_softmax(_scores(weights, shares[out]), axis=1)
    return -float(np.mean(logarithms[np.arange(out.sum()), outcomes[out]]))


def _fitted(shares: Array, outcomes: NDArray[np.int64], penalty: float) -> Array:
    """Weights of least penalised loss; the problem is convex."""
    features = _features(shares)
    shape = (features.shape[1], len(CLASSES) - 1)
    one_hot = np.eye(len(CLASSES))[outcomes]

    def loss(flat: Array) -> tuple[float, Array]:
        weights = flat.reshape(shape)
        scores = np.concatenate((np.zeros((len(features), 1)), features @ weights), axis=1)
        logarithms = log_softmax(scores, axis=1)
        gradient = features.T @ (np.exp(logarithms) - one_hot)[:, 1:]
        gradient[1:] += penalty * weights[1:]
        value = -float((logarithms * one_hot).sum()) + 0.5 * penalty * float(
            (weights[1:] ** 2).sum()
        )
        return value, gradient.ravel()

    found = minimize(loss, np.zeros(shape).ravel(), jac=True, method="L-BFGS-B")
    weights: Array = found.x.reshape(shape)
    return weights
