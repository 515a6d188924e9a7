"""Part of a suite: the first trajectories of `tracking`, for solvers that would take hours for all.

Every trajectory is drawn by its own number, so that the first ones are the same however many there
are. The part keeps the checksum of the whole, whose first rows it is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

from pipeline.suites.generators import Suite

TRAJECTORY = "trajectory"  # column of the number


def first_trajectories(suite: Suite, count: int) -> Suite:
    """Return the rows of the first trajectories; a suite of single poses stays as it is."""
    number = suite.problems.further.get(TRAJECTORY)
    if number is None:
        return suite
    end = int(np.searchsorted(number, count))
    return replace(suite, problems=suite.problems.at(slice(0, end)))


def answered_part(suite: Suite, answers: pd.DataFrame) -> Suite:
    """Return the first trajectories that hold all poses answered; else the whole suite.

    Args:
        suite: That was answered.
        answers: With a column ``pose``, the row of the suite; nothing in it was checked.
    """
    number = suite.problems.further.get(TRAJECTORY)
    if number is None or "pose" not in answers:
        return suite
    last = pd.to_numeric(answers.pose, errors="coerce").max()
    if not 0 <= last < len(number):
        return suite
    return first_trajectories(suite, int(number[int(last)]) + 1)
