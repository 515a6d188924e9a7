"""Claims `misses_are_near` and `idle_raises_spread`, from raw rows of evaluations.

The first: answers of the network that are no success (10 mm and 20 deg in the paper's metric) lie
just above these limits. It holds for a network if more than half of them lie below twice both. The
second: the spread of TRAC-IK and BioIK stems from poses without an answer, which count as the idle
configuration. It holds for a solver and robot if the standard deviation of the position error over
answered poses alone is less than a fifth of that over all.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pandas as pd

from pipeline.config import compose
from pipeline.reporting.summary import counted, successes

NAME, SEEDS = "claim_misses", "those of the rows"
NEAR = 2.0  # times the limits of success
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
    sentences = []
    if misses:
        near = [row["near_percent"] for row in misses]
        sentences.append(
            f"{min(near):.0f} to {max(near):.0f} % of the network's misses lie below "
            f"{NEAR:g} times the limits: the first claim {_verdict(min(near) > 50)}"
        )
    if spreads:
        shares = [row["answered_sd_mm"] / row["all_sd_mm"] for row in spreads]
        sentences.append(
            f"without unanswered poses the standard deviation is {min(shares):.1g} to "
            f"{max(shares):.1g} of that with them: the second claim "
            f"{_verdict(max(shares) < IDLE_SHARE)}"
        )
    return pd.DataFrame([*misses, *spreads]), "; ".join(sentences) + "."


def _misses(rows: pd.DataFrame) -> dict[str, float]:
    config = compose().report
    limits = config.success.paper
    rows = counted(rows, config)
    missed = rows[~successes(rows, "paper", limits)]
    wider = replace(
        limits,
        position_mm=NEAR * limits.position_mm,
        rotation_deg=NEAR * limits.rotation_deg,
    )
    return {
        "poses": len(rows),
        "misses": len(missed),
        "near_percent": 100 * float(successes(missed, "paper", wider).mean()),
        "miss_median_mm": float(missed.paper_position_error_mm.median()),
        "miss_95_percent_mm": float(missed.paper_position_error_mm.quantile(0.95)),
    }


def _spreads(rows: pd.DataFrame) -> dict[str, float]:
    config = compose().report
    both = {
        policy: counted(rows, replace(config, not_found=policy)).paper_position_error_mm
        for policy in ("idle", "nan")
    }
    return {
        "poses": len(both["idle"]),
        "answered_percent": 100 * float(both["nan"].notna().mean()),
        "all_sd_mm": float(both["idle"].std()),
        "answered_sd_mm": float(both["nan"].std()),
    }


def _verdict(holds: bool) -> str:
    return "holds" if holds else "does not hold"
