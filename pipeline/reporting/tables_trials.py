"""Table of grasping, with the paper's numbers beside."""

from __future__ import annotations

import pandas as pd

from pipeline.evaluation.statistics import wilson_interval
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.naming import (
    OUTCOMES,
    ordered_robots,
    outcome_key,
    robot_title,
)
from pipeline.reporting.published import Published
from pipeline.reporting.results import Results
from pipeline.reporting.table import Cell, Column, Table

PUBLISHED_TRIALS = 100
OUTCOME_COLUMNS = (
    Column("trials", "trials"),
    Column("count", "count"),
    Column("share", "ours", "share [%]", percent=1),
    Column("share_low", "from", "share [%]", percent=1),
    Column("share_high", "to", "share [%]", percent=1),
    Column("share_paper", "paper", "share [%]", percent=0),
)


def grasping(results: Results, published: Published, config: ReportConfig) -> Table:
    """Figure 5 as a table: the share of each outcome, this run in simulation beside the paper."""
    table = Table(
        name="figure5_grasping",
        title="Figure 5: outcomes of grasp trials",
        caption=f"Share of trials by outcome with {config.confidence * 100:g} % Wilson intervals. "
        "This run is physics simulation; the paper's 100 trials a robot are on hardware, with its "
        "detector and language model.",
        columns=[
            Column("robot", "Robot"),
            Column("outcome", "Outcome"),
            *OUTCOME_COLUMNS,
            Column("share_difference", "Δ", "share [%]", percent=1, signed=True),
        ],
    )
    for robot in ordered_robots([*results.grasp, *published.robots("grasping")]):
        trials = results.grasp.get(robot)
        for key, title in OUTCOMES.items():
            cells = outcome_cells(trials, published, config, robot, key)
            share, paper = cells.get("share"), cells["share_paper"]
            if isinstance(share, float) and isinstance(paper, float):
                cells["share_difference"] = share - paper
            table.add(robot=robot_title(robot), outcome=title, **cells)
    return table


def outcome_cells(
    trials: pd.DataFrame | None, published: Published, config: ReportConfig, robot: str, key: str
) -> dict[str, Cell]:
    """Return the cells of `OUTCOME_COLUMNS` for one outcome of a robot.

    Args:
        trials: Raw rows; None where there are none.
        published: The paper's counts.
        config: Confidence of the interval.
        robot: Name of the robot.
        key: Of `naming.OUTCOMES`.
    """
    paper = published.number("grasping", robot, "cycleik", key)
    cells: dict[str, Cell] = {"share_paper": None if paper is None else paper / PUBLISHED_TRIALS}
    if trials is not None:
        count = int((trials["class"].map(outcome_key) == key).sum())
        share = wilson_interval(count, len(trials), config.confidence)
        cells |= {"trials": len(trials), "count": count, "share": share.estimate}
        cells |= {"share_low": share.low, "share_high": share.high}
    return cells
