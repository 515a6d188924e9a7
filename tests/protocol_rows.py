"""Rows and rules of protocols that are small enough to be judged by hand."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd

from pipeline.data.files import read_yaml
from pipeline.locations import CONF_DIR
from pipeline.protocols.config import (
    ErrorRule,
    ProtocolConfig,
    RankRule,
    SuccessRule,
    from_facts,
)

FAMILIES = ("", "paper_", "axis_")


def protocol(**changes: Any) -> ProtocolConfig:
    """One pose a call; success below 1 mm and 1 deg; the mean Euclidean error; ranked by success.

    Keys with a dot, such as ``rank__by``, change one value of a rule.
    """
    rules: dict[str, dict[str, Any]] = {
        "success": {
            "errors": "euclidean",
            "position_mm": 1.0,
            "rotation_deg": 1.0,
            "limits": False,
        },
        "errors": {"kind": "euclidean", "statistic": "mean", "of": "all", "not_found": "own"},
        "rank": {"by": "success", "digits": 4},
    }
    values: dict[str, Any] = {
        "name": "plain",
        "title": "Plain",
        "source": "nobody",
        "solvers": ["lm"],
        "targets": "uniform",
        "within_deg": [],
        "poses": 100,
        "most_poses": 100,
        "start": "home",
        "time_s": None,
        "iterations": None,
        "tolerance": None,
        "draws": 1,
        "best_draw": False,
        "batch_sizes": [1],
        "ranked_batch": 1,
        "one_call": False,
        "warm_up_calls": 0,
        "time_statistic": "mean",
    }
    for key, value in changes.items():
        rule, _, part = key.partition("__")
        (rules[rule] if part else values)[part or key] = value
    return ProtocolConfig(
        **values,
        success=SuccessRule(**rules["success"]),
        errors=ErrorRule(**rules["errors"]),
        rank=RankRule(**rules["rank"]),
    )


def protocol_of(name: str, most_poses: int) -> ProtocolConfig:
    """A protocol of conf/protocol at the scale of so many targets."""
    folder = CONF_DIR / "protocol"
    common, own = read_yaml(folder / "common" / "default.yaml"), read_yaml(folder / f"{name}.yaml")
    values = {**common, **{key: value for key, value in own.items() if key != "defaults"}}
    return from_facts({**values, "most_poses": most_poses})


def facts(rules: ProtocolConfig) -> dict[str, Any]:
    """What the metadata of such rows say."""
    kept = {key: value for key, value in asdict(rules).items() if key != "solvers"}
    return {"protocol": kept, "poses_checksum": "same"}


def answers(
    position_mm: Sequence[float],
    time_us: Sequence[float] | float = 100.0,
    draws: int = 1,
    batch_size: int = 1,
    **columns: Any,
) -> pd.DataFrame:
    """Rows with these position errors in all families, without rotation errors; idle is 100 mm."""
    number = np.arange(len(position_mm))
    values: dict[str, Any] = {
        "pose": number,
        "target": number // draws,
        "call": number // batch_size,
        "batch_size": batch_size,
        "answered": True,
        "within_limits": True,
        "time_per_pose_us": np.broadcast_to(time_us, len(number)).astype(float),
        "machine": "aaaa",
    }
    for family in FAMILIES:
        values |= {
            f"{family}position_error_mm": np.asarray(position_mm, dtype=float),
            f"{family}rotation_error_deg": np.zeros(len(number)),
            f"{family}idle_position_error_mm": np.full(len(number), 100.0),
            f"{family}idle_rotation_error_deg": np.full(len(number), 90.0),
        }
    return pd.DataFrame({**values, **columns})
