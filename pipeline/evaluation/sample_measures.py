"""How good many solutions of one pose are: precise, and all there are.

What there is, is known from reference solutions by Levenberg-Marquardt from random starts. They
reach every basin with enough starts, but a basin as often as it is wide: no uniform distribution
over the solutions.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial.distance import cdist, pdist

from pipeline.evaluation.sampling import joint_columns

Array = NDArray[np.float64]

RADIUS = 0.3  # rad or m: solutions of a cluster differ in no joint by more, and a draw hits it so
KERNEL_WIDTH = 0.5  # rad: of the Gaussian kernel on joints
POSITION_UNIT_MM, ROTATION_UNIT_DEG = 10.0, 20.0  # what an error counts when draws are compared


def best_of(rows: pd.DataFrame, count: int) -> pd.DataFrame:
    """Return the best of the first solutions of each pose, by the sum of its errors in units.

    Args:
        rows: Rows of one robot and solver, all before or all after refinement.
        count: How many solutions of a pose are looked at.
    """
    looked_at = rows[rows["sample"] < count]
    score = looked_at.position_error_mm / POSITION_UNIT_MM
    score = score + looked_at.rotation_error_deg / ROTATION_UNIT_DEG
    return looked_at.loc[score.groupby(looked_at.pose).idxmin()]


def clusters(solutions: Array) -> NDArray[np.int64]:
    """Return the cluster (R,), from 1, of solutions (R, dof): none is wider than `RADIUS`.

    By complete linkage of the largest difference of a joint. The finitely many solutions of six
    joints are a cluster each, the curves of a redundant arm are cut into pieces.
    """
    if len(solutions) < 2:
        return np.ones(len(solutions), dtype=np.int64)
    tree = linkage(pdist(solutions, "chebyshev"), "complete")
    return fcluster(tree, RADIUS, criterion="distance").astype(np.int64)


def coverage(drawn: Array, solutions: Array) -> float:
    """Return the share of clusters of solutions (R, dof) that draws (K, dof) hit.

    A draw hits a cluster when it is within `RADIUS` of one of its solutions in every joint; NaN
    where there are no solutions.
    """
    if not len(solutions):
        return float("nan")
    if not len(drawn):
        return 0.0
    hit = cdist(solutions, drawn, "chebyshev").min(axis=1) <= RADIUS
    labels = clusters(solutions)
    return len(np.unique(labels[hit])) / len(np.unique(labels))


def squared_discrepancy(drawn: Array, solutions: Array) -> float:
    """Return the squared maximum mean discrepancy of draws (K, dof) and solutions (R, dof).

    The unbiased estimate of Gretton et al., *A Kernel Two-Sample Test*, JMLR 2012, lemma 6, with
    the kernel exp(-|a - b|² / (2 w²)), w = `KERNEL_WIDTH`. It can be negative where both are alike;
    NaN with fewer than two of either.
    """
    if min(len(drawn), len(solutions)) < 2:
        return float("nan")
    within = [_kernel(values, values) for values in (drawn, solutions)]
    own = [(k.sum() - len(k)) / (len(k) * (len(k) - 1)) for k in within]
    return float(sum(own) - 2 * _kernel(drawn, solutions).mean())


def by_pose(drawn: pd.DataFrame, references: pd.DataFrame) -> pd.DataFrame:
    """Return coverage, clusters and discrepancy of each pose.

    Args:
        drawn: Rows of what was drawn, all before or all after refinement.
        references: Rows of the references. Of both, what was not found from its own start is left
            out: the random starts that follow are a function of the pose, the same for all rows.

    Returns:
        A row a pose: ``coverage``, ``clusters``, ``squared_discrepancy``.
    """
    names = joint_columns(drawn)
    found, lines = references[references.found & (references.starts == 1)], {}
    for pose, rows in drawn.groupby("pose"):
        joints = rows.loc[rows.starts <= 1, names].to_numpy(dtype=float)
        solutions = found.loc[found.pose == pose, names].to_numpy(dtype=float)
        lines[pose] = {
            "coverage": coverage(joints, solutions),
            "clusters": len(np.unique(clusters(solutions))),
            "squared_discrepancy": squared_discrepancy(joints, solutions),
        }
    return pd.DataFrame.from_dict(lines, orient="index")


def _kernel(first: Array, second: Array) -> Array:
    squares: Array = cdist(first, second, "sqeuclidean")
    return np.exp(-squares / (2 * KERNEL_WIDTH**2))
