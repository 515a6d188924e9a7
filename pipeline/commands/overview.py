"""The first figure of README.md: error against time of all solvers, from the leaderboard."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from pipeline.data.files import replacing
from pipeline.errors import MissingArtifactError
from pipeline.leaderboard.boards import read_boards
from pipeline.presentation.columns import significant
from pipeline.presentation.naming import NEURAL, solver_title
from pipeline.presentation.style import INK, SOFT, logarithmic, looks, styled
from pipeline.provenance import digest

SUITE = "uniform"
ERROR, TIME, GOOD, POSES = "position_mean_mm", "time_median_us", "good_poses", "poses"
SIZE = (7.2, 4.0)  # inch
DPI = 160


def lines_of(results: Path) -> pd.DataFrame:
    """Return the lines of the suite `uniform` of the machine that has most of them.

    Raises:
        MissingArtifactError: There are none.
    """
    lines = read_boards(results / "leaderboard")
    lines = lines[lines.suite == SUITE] if len(lines) else lines
    if not len(lines):
        raise MissingArtifactError(f"{results / 'leaderboard'} has no lines of {SUITE}")
    return lines[lines.machine == lines.machine.value_counts().index[0]]


def over_robots(lines: pd.DataFrame) -> pd.DataFrame:
    """Return a row a solver that has all robots: geometric means of error and time, share solved.

    Args:
        lines: Of one suite on one machine.

    Returns:
        Columns ``error_mm``, ``time_us``, ``solved`` (0 to 1), by solver, the quickest first.
    """
    robots = lines.robot.nunique()
    rows = {
        solver: {
            "error_mm": float(np.exp(np.log(mine[ERROR]).mean())),
            "time_us": float(np.exp(np.log(mine[TIME]).mean())),
            "solved": float(mine[GOOD].sum() / mine[POSES].sum()),
        }
        for solver, mine in lines.groupby("solver")
        if mine.robot.nunique() == robots
    }
    return pd.DataFrame.from_dict(rows, orient="index").sort_values("time_us")


def in_words(lines: pd.DataFrame) -> str:
    """Return the table below the figure, in Markdown."""
    head = [
        "| solver | solved to 1 mm and 1 deg | mean error (geometric) | median time a pose |",
        "| --- | ---: | ---: | ---: |",
    ]
    rows = [
        f"| {solver_title(str(solver))} | {100 * row.solved:.1f} % "
        f"| {significant(row.error_mm, 2)} mm | {row.time_us:,.0f} µs |"
        for solver, row in over_robots(lines).iterrows()
    ]
    return "\n".join([*head, *rows])


def draw(lines: pd.DataFrame, path: Path) -> None:
    """Draw each solver on each robot, and its mean over the robots with its name.

    Args:
        lines: Of one suite on one machine.
        path: Of the PNG.
    """
    means = over_robots(lines)
    look = looks(means.index)
    with styled():
        figure = Figure(figsize=SIZE, layout="constrained")
        axis = figure.subplots()
        for number, solver in enumerate(means.index):
            mine, mean = lines[lines.solver == solver], means.loc[str(solver)]
            colour, marker = look[solver].colour, look[solver].marker
            axis.scatter(mine[TIME], mine[ERROR], s=16, c=colour, marker=marker, alpha=0.35, lw=0)
            axis.scatter(mean.time_us, mean.error_mm, s=80, c=colour, marker=marker, zorder=3)
            axis.annotate(
                solver_title(solver),
                (mean.time_us, mean.error_mm),
                # Neighbours in time do not meet: the quickest has its name to the left.
                xytext=(7, 6 if number % 2 else -14) if number else (-8, -4),
                ha="left" if number else "right",
                textcoords="offset points",
                color=INK,
                weight="bold" if solver in NEURAL else "normal",
            )
        axis.set_xlabel("time a pose [µs], one core, one pose a call")
        axis.set_ylabel("mean position error [mm]")
        logarithmic(axis, "x")
        logarithmic(axis, "y")
        axis.margins(0.18, 0.12)
        robots, poses = lines.robot.nunique(), int(lines[POSES].max())
        axis.set_title(
            f"{robots} robots (small), their geometric means (large), {poses} poses each",
            color=SOFT,
            weight="normal",
        )
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as partial:
            made_of = {"Software": None, "Source": digest_of(lines)}
            figure.savefig(partial, dpi=DPI, metadata=made_of, format="png")


def digest_of(lines: pd.DataFrame) -> str:
    """Return the checksum of what is drawn, which the picture carries."""
    return digest(lines[["robot", "solver", ERROR, TIME, POSES]].to_csv(index=False))
