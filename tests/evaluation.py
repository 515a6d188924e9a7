"""Settings of an evaluation of scripted solvers."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from pipeline.evaluation.config import EvaluateConfig, Tolerance

PLAIN = EvaluateConfig(
    solvers=["scripted"],
    seeded_by="home",
    poses=0,
    time_s=None,
    time_factor={},
    iterations=None,
    not_found="idle",
    claim=Tolerance(position_mm=10.0, rotation_deg=20.0),
    limit_slack=1e-6,
    batch_sizes=[1],
    error_batch_size={},
    trajectories=0,
    latency_poses=4,
    warm_up=0,
    threads=1,
    pinned=True,
    first_core=0,
    side_by_side=1,
    keep=False,
    chunk=5,
)


def evaluate_config(**changed: Any) -> EvaluateConfig:
    """Return plain settings with some of them changed."""
    return replace(PLAIN, **changed)
