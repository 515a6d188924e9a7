"""Whether the numerical rivals here are those of their authors and of the paper.

The rows are those of studies that are committed (`python -m benchmarks.calibration` and
`python -m benchmarks.bio_ik_budget`).
"""

from __future__ import annotations

import pandas as pd

from pipeline.presentation.columns import ROBOT, count, number, text, under
from pipeline.presentation.table import Table
from pipeline.reporting.committed import committed
from pipeline.reporting.data import Topic

CALIBRATION, BUDGETS = "calibration", "bio_ik_budget"
SOLVED = (
    number("low_percent", "low", decimals=2),
    number("high_percent", "high", decimals=2),
)
ARMS = (
    text("arm", "Arm"),
    count("joints", "joints"),
    count("poses", "poses"),
    *under(
        "solved [%]",
        number("solved_percent", "here", decimals=2),
        *SOLVED,
        number("published_percent", "published", decimals=2),
    ),
    *under(
        "mean time [ms]",
        number("mean_ms", "here", decimals=2),
        number("published_ms", "published", decimals=2),
    ),
)
MILLISECONDS = (
    ROBOT,
    number("budget_ms", "budget [ms]", decimals=0),
    count("poses", "poses"),
    *under(
        "position error [mm]",
        number("position_mm", "here"),
        number("published_mm", "published"),
    ),
    *under(
        "rotation error [deg]",
        number("rotation_deg", "here"),
        number("published_deg", "published"),
    ),
    *under(
        "success [%]",
        number("success_percent", "here", decimals=2),
        *SOLVED,
        number("published_percent", "published", decimals=2),
    ),
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
