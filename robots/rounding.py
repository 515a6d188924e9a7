"""Values as they are stored: two machines whose sine differs in its last bit give the same."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

DECIMALS = 9  # a nanometre, a nanoradian


def rounded(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values as they are stored; a negative zero becomes zero."""
    return np.asarray(np.round(values, DECIMALS) + 0.0)
