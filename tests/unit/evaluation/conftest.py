"""A two-link arm and the settings of a small evaluation."""

from pathlib import Path

import pytest

from pipeline.evaluation.config import EvaluateConfig, Tolerance
from robots import load_robot

TWO_LINK = Path(__file__).parents[2] / "fixtures" / "two_link.urdf"


@pytest.fixture(scope="module")
def robot():
    return load_robot(urdf=TWO_LINK)


@pytest.fixture
def config():
    return EvaluateConfig(
        solvers=["scripted"],
        seeded_by="home",
        poses=0,
        time_s=None,
        iterations=None,
        not_found="idle",
        claim=Tolerance(position_mm=10.0, rotation_deg=20.0),
        limit_slack=1e-6,
        batch_sizes=[1],
        error_batch_size={},
        latency_poses=4,
        warm_up=0,
        threads=1,
        pinned=True,
        first_core=0,
        side_by_side=1,
        keep=False,
        chunk=5,
    )
