"""Claims `misses_are_near` and `idle_raises_spread`, from raw rows of evaluations.

The first: answers of the network that are no success (10 mm and 20 deg in the paper's metric) lie
just above these limits. It holds for a network if more than half of them lie below twice both. The
second: the spread of TRAC-IK and BioIK stems from poses without an answer, which count as the idle
configuration. It holds for a solver and robot if the standard deviation of the position error over
answered poses alone is less than a fifth of that over all.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd

NAME, SEEDS = "claim_misses", "those of the rows"
LIMIT_MM, LIMIT_DEG = 10.0, 20.0
IDLE_SHARE = 0.2
NUMERICAL = ("trac_ik", "bio_ik")


def run(rows: list[Path]) -> tuple[pd.DataFrame, str]:
    """Read the rows of results/<profile>/evaluate; rows of both claims and their verdicts."""
    misses, spreads = [], []
    for path in sorted(each for folder in rows for each in folder.glob("*/*.parquet")):
        profile, robot, solver = path.parts[-4], path.parent.name, path.stem
        names = {"profile": profile, "robot": robot, "solver": solver}
        if solver == "cycleik":
            misses.append({**names, **_misses(pd.read_parquet(path))})
        elif solver in NUMERICAL:
            spreads.append({**names, **_spreads(pd.read_parquet(path))})
    near = [row["near_percent"] for row in misses]
    shares = [row["answered_sd_mm"] / row["all_sd_mm"] for row in spreads]
    spread = _verdict(all(share < IDLE_SHARE for share in shares))
    sentences = [
        f"{min(near):.0f} to {max(near):.0f} % of the network's misses lie below twice the limits: "
        f"the first claim {_verdict(all(each > 50 for each in near))}"
        if near
        else "No rows of the network",
        f"without unanswered poses the standard deviation is {min(shares):.1g} to "
        f"{max(shares):.1g} of that with them: the second claim {spread}"
        if shares
        else "no rows of TRAC-IK and BioIK",
    ]
    return pd.DataFrame([*misses, *spreads]), "; ".join(sentences) + "."


def _first_batch(rows: pd.DataFrame) -> pd.DataFrame:
    return rows[rows.batch_size == rows.batch_size.iloc[0]]


def _misses(rows: pd.DataFrame) -> dict[str, float]:
    rows = _first_batch(rows)
    position, rotation = rows.paper_position_error_mm, rows.paper_rotation_error_deg
    missed = rows[(position >= LIMIT_MM) | (rotation >= LIMIT_DEG)]
    near = (missed.paper_position_error_mm < 2 * LIMIT_MM) & (
        missed.paper_rotation_error_deg < 2 * LIMIT_DEG
    )
    return {
        "poses": len(rows),
        "misses": len(missed),
        "near_percent": 100 * float(near.mean()),
        "miss_median_mm": float(missed.paper_position_error_mm.median()),
        "miss_95_percent_mm": float(missed.paper_position_error_mm.quantile(0.95)),
    }


def _spreads(rows: pd.DataFrame) -> dict[str, float]:
    rows = _first_batch(rows)
    counted = np.where(
        rows.answered, rows.paper_position_error_mm, rows.paper_idle_position_error_mm
    )
    return {
        "poses": len(rows),
        "answered_percent": 100 * float(rows.answered.mean()),
        "all_sd_mm": float(counted.std()),
        "answered_sd_mm": float(rows.paper_position_error_mm[rows.answered].std()),
    }


def _verdict(holds: bool) -> str:
    return "holds" if holds else "does not hold"
