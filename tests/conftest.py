"""What all tests share: one thread for torch, results away from the checkout."""

from __future__ import annotations

import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # before torch and numba are loaded

import pytest


@pytest.fixture(scope="session")
def shared_results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Give a results folder that tests of one session may build on."""
    return tmp_path_factory.mktemp("results")
