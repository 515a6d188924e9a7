"""What all tests share: one thread for torch and numba."""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before torch and numba are loaded
