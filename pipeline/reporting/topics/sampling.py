"""Solvers that draw many solutions of a pose, measured against the solutions there are."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import pandas as pd

from pipeline.evaluation import sample_measures as measures
from pipeline.evaluation.sampling import drawn_rows
from pipeline.presentation.columns import ROBOT, SOLVER, count, number, share, text, under
from pipeline.presentation.naming import ordered_robots
from pipeline.presentation.table import Table
from pipeline.reporting.data import Topic
from pipeline.reporting.results import Results

FEW = 10  # draws of the smaller choice


@dataclass(frozen=True)
class Measured:
    """Draws of a solver, before or after refinement, and the references of their poses."""

    robot: str
    solver: str
    refined: bool
    rows: pd.DataFrame
    references: pd.DataFrame

    @cached_property
    def by_pose(self) -> pd.DataFrame:
        """Coverage, clusters and discrepancy, a row a pose."""
        return measures.by_pose(self.rows, self.references)

    @property
    def samples(self) -> int:
        """Draws of each pose."""
        return int(self.rows["sample"].nunique())

    def best(self, column: str, samples: int) -> float:
        """Return the mean over poses of an error of the best of so many draws."""
        return float(measures.best_of(self.rows, samples)[column].mean())


def _best(column: str, samples: int | None) -> Callable[[Measured], float]:
    return lambda line: line.best(column, samples or line.samples)


def _mean(column: str) -> Callable[[Measured], float]:
    return lambda line: float(line.rows[column].mean())


def _over_poses(column: str) -> Callable[[Measured], float]:
    return lambda line: float(line.by_pose[column].mean())


COLUMNS = (
    ROBOT,
    SOLVER,
    text("refined", "Stage", lambda line: "refined" if line.refined else "drawn"),
    count("poses", "poses", lambda line: line.rows.pose.nunique()),
    count("samples", "draws of each"),
    *under(
        "position error [mm]",
        number("position_mean_mm", "mean", _mean("position_error_mm")),
        number("position_few_mm", f"best of {FEW}", _best("position_error_mm", FEW)),
        number("position_best_mm", "best of all", _best("position_error_mm", None)),
    ),
    *under(
        "rotation error [deg]",
        number("rotation_mean_deg", "mean", _mean("rotation_error_deg")),
        number("rotation_few_deg", f"best of {FEW}", _best("rotation_error_deg", FEW)),
        number("rotation_best_deg", "best of all", _best("rotation_error_deg", None)),
    ),
    share("coverage", "coverage [%]", _over_poses("coverage")),
    number("clusters", "clusters of a pose", _over_poses("clusters")),
    number("squared_discrepancy", "MMD²", _over_poses("squared_discrepancy")),
    share("in_collision", "in self-collision [%]", _mean("in_collision")),
)


def sampler_measures(results: Results) -> Table:
    """Precision, coverage, discrepancy and collisions of what solvers draw."""
    lines = [
        Measured(robot, solver, refined, drawn_rows(rows, refined), rows[rows.reference])
        for robot in ordered_robots(robot for robot, _ in results.sample)
        for (name, solver), rows in results.sample.items()
        if name == robot and "reference" in rows and rows.reference.any()
        for refined in (False, True)
    ]
    return Table.of(
        lines,
        COLUMNS,
        name="sampler_measures",
        title="Solvers that draw, against the solutions there are",
        caption="Errors: mean over draws, and of the best of some, by error in units of "
        f"{measures.POSITION_UNIT_MM:g} mm and {measures.ROTATION_UNIT_DEG:g} deg. References: "
        "solutions of the compiled Levenberg-Marquardt, each in one descent from a random start of "
        "its own, clustered by complete "
        f"linkage so that no joint differs by more than {measures.RADIUS:g} rad in a cluster. "
        "Coverage: share of clusters with a draw that near to a reference; a draw whose "
        "refinement restarted elsewhere counts in errors alone. MMD²: unbiased squared "
        "maximum mean discrepancy of draws and references, Gaussian kernel of width "
        f"{measures.KERNEL_WIDTH:g} rad on the joints. All by pose, mean over poses.",
    )


TOPIC = Topic(tables=(lambda data: sampler_measures(data.results),), stages=("sample",))
