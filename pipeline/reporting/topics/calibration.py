"""Whether the numerical rivals here are those of their authors and of the paper.

The rows are those of studies that are committed (`python -m benchmarks.calibration` and
`python -m benchmarks.bio_ik_budget`).
"""

from __future__ import annotations

import pandas as pd

from pipeline.presentation.columns import ROBOT, Column, count, number, text, under
from pipeline.presentation.table import Table
from pipeline.reporting.committed import committed
from pipeline.reporting.data import Topic

CALIBRATION, BUDGETS = "calibration", "bio_ik_budget"


def _beside(
    title: str, here: str, published: str, decimals: int | None = None
) -> tuple[Column, ...]:
    """Our number and the published one under a title."""
    return under(
        title,
        number(here, "here", decimals=decimals),
        number(published, "published", decimals=decimals),
    )


def _solved(title: str, here: str) -> tuple[Column, ...]:
    """A rate of ours with its interval, and the published one [%]."""
    return under(
        title,
        number(here, "here", decimals=2),
        number("low_percent", "low", decimals=2),
        number("high_percent", "high", decimals=2),
        number("published_percent", "published", decimals=2),
    )


ARMS = (
    text("arm", "Arm"),
    count("joints", "joints"),
    count("poses", "poses"),
    *_solved("solved [%]", "solved_percent"),
    *_beside("mean time [ms]", "mean_ms", "published_ms", decimals=2),
)
MILLISECONDS = (
    ROBOT,
    number("budget_ms", "budget [ms]", decimals=0),
    count("poses", "poses"),
    *_beside("position error [mm]", "position_mm", "published_mm"),
    *_beside("rotation error [deg]", "rotation_deg", "published_deg"),
    *_solved("success [%]", "success_percent"),
    number("mean_ms", "mean time [ms]", decimals=2),
)


def trac_ik_calibration(rows: pd.DataFrame) -> Table:
    """TRAC-IK under its authors' protocol beside what they published."""
    return Table.of(
        rows,
        ARMS,
        name=CALIBRATION,
        title="TRAC-IK by its authors' own protocol",
        caption="Random configurations, each solved from the middle of the limits within 5 ms to "
        "1e-5 in every component of the twist; 95 % Wilson intervals. Published: README of "
        "trac_ik 1.4.6 (Beeson and Ames). Where these agree, TRAC-IK here is the TRAC-IK that its "
        "authors measured, and what it does in Table II is that table's protocol.",
    )


def bio_ik_budgets(rows: pd.DataFrame) -> Table:
    """BioIK under several budgets beside the paper's row."""
    return Table.of(
        rows,
        MILLISECONDS,
        name=BUDGETS,
        title="BioIK with the paper's processor time",
        caption="The paper's BioIK had four threads for its millisecond; ours has one, so its row "
        "of 4 ms has the same processor time. Errors as in Table II, from the idle configuration, "
        "which stands in for what was not found too; 95 % Wilson intervals.",
    )


TOPIC = Topic(
    tables=(
        lambda data: committed(data.results, CALIBRATION, trac_ik_calibration),
        lambda data: committed(data.results, BUDGETS, bio_ik_budgets),
    ),
    stages=(),
)
