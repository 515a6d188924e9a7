"""The paper's Tables II and III, solvers against each other, with this run beside the paper."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.evaluation.config import solver_of_rows
from pipeline.presentation.columns import ROBOT, SOLVER, Column, count, number, share, text, under
from pipeline.presentation.naming import (
    NEURAL,
    ordered_robots,
    ordered_solvers,
    robot_title,
    solver_title,
)
from pipeline.presentation.published import Published
from pipeline.presentation.style import INK, PAPER_COLOUR, legend_below, logarithmic, panels
from pipeline.presentation.table import Table
from pipeline.reporting.data import Plot, Topic

NUMERICAL, NETWORKS = "numerical_comparison", "neural_comparison"  # tables of published numbers


@dataclass(frozen=True)
class Compared:
    """A solver on a robot: the lines of our summary and the paper's numbers.

    Attributes:
        table: Of the published numbers.
        robot: Name of the robot.
        solver: Name of the solver in the rows.
        summary: From `summarise`; may be empty.
        published: The paper's numbers.
    """

    table: str
    robot: str
    solver: str
    summary: pd.DataFrame
    published: Published

    @cached_property
    def lines(self) -> pd.DataFrame:
        """Lines of the summary, one a batch size."""
        every = self.summary
        if every.empty:
            return every
        return every[(every.robot == self.robot) & (every.solver == self.solver)]

    def ours(self, column: str, batch_size: int | None = None) -> float | None:
        """Return a column of the summary at a batch size, the main one by default."""
        if self.lines.empty:
            return None
        found = self.lines
        wanted = found.main if batch_size is None else found.batch_size == batch_size
        return float(found.loc[wanted, column].iloc[0]) if wanted.any() else None

    @property
    def network(self) -> str | None:
        """Network that our rows were made with, None for a solver without or for older rows."""
        if self.lines.empty or "network" not in self.lines:
            return None
        name = self.lines.network.iloc[0]
        return str(name) if isinstance(name, str) and name else None

    def paper(self, metric: str) -> float | None:
        """Return the paper's number: it has one TRAC-IK, whether ours was pinned or not."""
        return self.published.number(self.table, self.robot, solver_of_rows(self.solver), metric)


@dataclass(frozen=True)
class Metric:
    """A metric of the paper beside ours.

    Attributes:
        name: Of the published numbers, and of the column.
        title: Heading.
        column: Of our summary.
        factor: From our unit to the paper's.
        batch_size: Where it is read off; None for the batch size with most poses.
    """

    name: str
    title: str
    column: str
    factor: float = 1.0
    batch_size: int | None = None

    def ours(self, line: Compared) -> float | None:
        """Return our number in the paper's unit."""
        value = line.ours(self.column, self.batch_size)
        return None if value is None else value * self.factor

    def difference(self, line: Compared) -> float | None:
        """Return ours minus the paper's, where there are both."""
        ours, paper = self.ours(line), line.paper(self.name)
        return None if ours is None or paper is None else ours - paper

    def columns(self) -> tuple[Column, ...]:
        """Return the columns ours, paper and their difference."""
        decimals = 2 if self.name == "success_rate" else None
        return under(
            self.title,
            number(self.name, "ours", self.ours, decimals=decimals),
            text(f"{self.name}_paper", "paper", lambda line: line.paper(self.name)),
            number(
                f"{self.name}_difference", "Δ", self.difference, 2, decimals=decimals, signed=True
            ),
        )


POSITION = Metric("position_error_mean", "pos. [mm]", "paper_position_error_mm_mean")
ROTATION = Metric("rotation_error_mean", "rot. [deg]", "paper_rotation_error_deg_mean")
SUCCESS = Metric("success_rate", "success [%]", "success_paper", 100.0)
LABELS = {POSITION: "mean position error [mm]", ROTATION: "mean rotation error [deg]"}
LABELS |= {SUCCESS: SUCCESS.title}
TABLE_II = (
    POSITION,
    Metric("position_error_sd", "σ pos. [mm]", "paper_position_error_mm_sd"),
    ROTATION,
    Metric("rotation_error_sd", "σ rot. [deg]", "paper_rotation_error_deg_sd"),
    SUCCESS,
    Metric("time_per_pose", "time [ms]", "time_per_pose_mean_us", 1e-3, batch_size=1),
)
HUNDRED = Metric(
    "time_per_batch_of_100", "time of 100 [ms]", "time_per_batch_mean_ms", batch_size=100
)
TABLE_III = (POSITION, ROTATION, HUNDRED)


def _of(column: str) -> Callable[[Compared], float | None]:
    return lambda line: line.ours(column)


OWN_METRIC = under(
    "our metric",
    number("euclidean_mm", "Euclidean [mm]", _of("position_error_mm_mean")),
    number("geodesic_deg", "geodesic [deg]", _of("rotation_error_deg_mean")),
    share("strict", "1 mm, 1 deg [%]", _of("success_strict"), 2),
    share("strict_low", "from", _of("success_strict_low"), 2),
    share("strict_high", "to", _of("success_strict_high"), 2),
)
POSES = count("poses", "poses", _of("poses"))
NETWORK = text("network", "Network", lambda line: line.network)
CORES = count("cores", "cores", _of("threads"))


def numerical_comparison(summary: pd.DataFrame, published: Published) -> Table:
    """Table II: precision, success and time per pose in the paper's metric, and in ours.

    Args:
        summary: From `summarise`; may be empty.
        published: The paper's numbers.

    Returns:
        One row per robot and solver; a solver that only the paper has keeps a row.
    """
    return Table.of(
        _compared(NUMERICAL, ordered_robots(summary.get("robot", [])), summary, published),
        (ROBOT, SOLVER, *_columns(TABLE_II), *OWN_METRIC, POSES, CORES, NETWORK),
        name="table2_numerical_comparison",
        title="Table II: CycleIK and numerical solvers",
        caption="Errors averaged over the axes and success below 10 mm and 20 deg on those "
        "averages, as in the paper; time is the mean per pose at batch size 1. Each number of "
        "this run (ours) stands beside the paper's, with the difference Δ (ours − paper). Our "
        "metric: mean Euclidean distance and geodesic angle, and the share of poses below 1 mm and "
        "1 deg of them with joint limits kept, with its Wilson interval.",
        notes=[
            *_note_on_poses(summary),
            "The paper's numerical solvers ran with 1 ms per pose in MoveIt, BioIK on four "
            "threads; budgets here are those of the configuration, in profile=paper 4 ms of one "
            "core for BioIK and 2 ms for TRAC-IK: the processor time of their threads there. Its "
            "network ran on a graphics processor. A solver that is unpinned may use every core; "
            "TRAC-IK races two threads, which share one core otherwise.",
        ],
    )


def neural_comparison(summary: pd.DataFrame, published: Published) -> Table:
    """Table III: neural solvers, with time for a batch of 100."""
    networks = summary[summary.solver.isin(NEURAL)] if len(summary) else summary
    source = text(
        "source", "Source", lambda line: "published" if line.ours("poses") is None else "this run"
    )
    return Table.of(
        _compared(NETWORKS, published.robots(NETWORKS), networks, published),
        (ROBOT, SOLVER, source, *_columns(TABLE_III), *OWN_METRIC, POSES, NETWORK),
        name="table3_neural_comparison",
        title="Table III: neural solvers",
        caption="Mean errors in the paper's metric (averages over the axes) beside the paper's "
        "numbers, and in our metric as Euclidean distance and geodesic angle, which is what IKFlow "
        "and EEM report. Time is the mean for a batch of 100 poses.",
        notes=[
            *_note_on_poses(networks),
            "Published numbers of IKFlow and EEM are Euclidean and geodesic, so the paper's table "
            "mixes metrics; IKFlow has no others here, EEM's are of our reduced re-implementation "
            "where this run has it. IKFlow's Valkyrie is the left arm with the waist, its Panda "
            "ends at panda_hand. Our flow answers with the best of its draws, where IKFlow's error "
            "is a mean over draws: that of ours is in the table of many solutions of one pose.",
        ],
    )


def against_the_paper(summary: pd.DataFrame, published: Published) -> Figure:
    """This run beside the paper on the numbers of Table II, solver by solver."""
    every = _compared(NUMERICAL, ordered_robots(summary.robot), summary, published)
    lines = [line for line in every if line.paper("success_rate") is not None and len(line.lines)]
    figure, axes = panels(3, 3.1, 0.9 + 0.32 * max(len(lines), 2))
    for axis, metric in zip(axes, LABELS, strict=True):
        for place, line in enumerate(lines):
            both = np.array([line.paper(metric.name), metric.ours(line)], dtype=float)
            paper, ours = both.tolist()
            axis.plot([paper, ours], [place, place], color=PAPER_COLOUR, linewidth=1.2, zorder=1)
            axis.plot(paper, place, "o", color="white", markeredgecolor=INK, label="paper")
            axis.plot(ours, place, "o", color=INK, label="this run")
        names = [f"{robot_title(line.robot)}, {solver_title(line.solver)}" for line in lines]
        axis.set_yticks(range(len(lines)), names if axis is axes[0] else [""] * len(lines))
        axis.set(xlabel=LABELS[metric], ylim=(len(lines) - 0.5, -0.5))
        if metric is not SUCCESS:
            logarithmic(axis, "x")
    legend_below(figure, axes)
    return figure


def _columns(metrics: Iterable[Metric]) -> list[Column]:
    return [column for metric in metrics for column in metric.columns()]


def _compared(
    table: str, robots: Iterable[str], summary: pd.DataFrame, published: Published
) -> list[Compared]:
    """Solvers that we or the paper have, on some robots."""
    lines = []
    for robot in robots:
        ours = [] if summary.empty else list(summary[summary.robot == robot].solver)
        names = ordered_solvers([*ours, *published.methods(table, robot)])
        lines += [Compared(table, robot, solver, summary, published) for solver in names]
    return lines


def _note_on_poses(summary: pd.DataFrame) -> list[str]:
    if summary.empty:
        return []
    poses = sorted({int(n) for n in summary[summary.main].poses})
    counts = " to ".join(f"{n:,}" for n in dict.fromkeys((poses[0], poses[-1])))
    return [f"This run: {counts} test poses a robot; the paper: 200,000."]


TOPIC = Topic(
    tables=(
        lambda data: numerical_comparison(data.summary, data.published),
        lambda data: neural_comparison(data.summary, data.published),
    ),
    plots=(
        Plot(
            "against_the_paper",
            "This run beside the paper's Table II, in the paper's metric.",
            lambda data: data.results.evaluate,
            lambda data: against_the_paper(data.summary, data.published),
        ),
    ),
)
