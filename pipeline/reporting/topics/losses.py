"""The former losses against the new ones at equal steps: bands over runs, and what they say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd
from matplotlib.figure import Figure

from pipeline.presentation.columns import ROBOT, Column, count, text
from pipeline.presentation.naming import ordered_robots, robot_title
from pipeline.presentation.style import LOOKS, legend_below, logarithmic, panels
from pipeline.presentation.table import Table
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.sweeps import SweptRun, alike

NEW, FORMER = "smooth", "former"
TITLES = {NEW: "new losses (equations 4, 5, 8)", FORMER: "former losses (equations 3, 6)"}
KINDS = (
    ("validation_position_error_mm", "position [mm]"),
    ("validation_rotation_error_deg", "rotation [deg]"),
)


@dataclass(frozen=True)
class LossComparison:
    """Runs of one robot that differ in the loss and the replicate only.

    Attributes:
        robot: Name of the robot.
        epochs: Epochs of each run.
        curves: By loss and kind of error: a row a validation (index: samples seen), a column a run.
    """

    robot: str
    epochs: int
    curves: dict[tuple[str, str], pd.DataFrame]

    def runs(self, loss: str) -> int:
        """Number of runs with a loss."""
        return len(self.curves[loss, KINDS[0][0]].columns)

    def mean(self, loss: str, kind: str) -> pd.Series:
        """Mean over the runs of a kind of error, by samples seen."""
        return self.curves[loss, kind].mean(axis=1)

    def gain(self, kind: str) -> float | None:
        """How many times fewer steps the new losses need for what the former reach in the end.

        None where they do not reach it.
        """
        last = float(self.mean(FORMER, kind).iloc[-1])
        new = self.mean(NEW, kind)
        there = new.index[new.to_numpy() <= last]
        return None if len(there) == 0 else float(new.index[-1] / there[0])


def compare_losses(runs: list[SweptRun]) -> list[LossComparison]:
    """Find the robots that were trained with the new and the former losses at equal steps."""
    found = []
    for group in alike(runs, ("loss",)):
        curves = {
            (loss, kind): _curves([run for run in group if run.train["loss"] == loss], kind)
            for loss in TITLES
            for kind, _ in KINDS
        }
        if all(len(frame) for frame in curves.values()):
            found.append(LossComparison(group[0].robot, int(group[0].train["epochs"]), curves))
    order = ordered_robots(comparison.robot for comparison in found)
    return sorted(found, key=lambda comparison: order.index(comparison.robot))


def losses_figure(found: list[LossComparison]) -> Figure:
    """Mean errors while training, with bands from the smallest to the largest of the runs."""
    figure, axes = panels(len(found) * len(KINDS), 3.7, 2.4, columns=len(KINDS))
    places = [(comparison, kind) for comparison in found for kind in KINDS]
    for axis, (comparison, (kind, label)) in zip(axes, places, strict=True):
        for look, (loss, title) in zip(LOOKS, TITLES.items(), strict=False):
            runs = comparison.curves[loss, kind]
            epochs = runs.index / runs.index[-1] * comparison.epochs
            axis.fill_between(
                epochs, runs.min(axis=1), runs.max(axis=1), color=look.colour, alpha=0.2, lw=0
            )
            mean = comparison.mean(loss, kind)
            axis.plot(
                epochs,
                mean,
                color=look.colour,
                linestyle=look.line,
                marker=look.marker,
                markersize=3,
                label=title,
            )
        axis.set(xlabel="epochs", ylabel=label, title=robot_title(comparison.robot))
        logarithmic(axis, "y")
    legend_below(figure, axes)
    return figure


def verdict(found: list[LossComparison]) -> str:
    """Say from the curves how much faster the new losses are at equal weights.

    That decides nothing about the paper's claim: the new rotation loss sums four components where
    the former averages them, so equal weights are no equal terms, and no run has 100 epochs.
    """
    parts = []
    for comparison in found:
        ends = {
            loss: " / ".join(f"{comparison.mean(loss, kind).iloc[-1]:.3g}" for kind, _ in KINDS)
            for loss in TITLES
        }
        both = [comparison.gain(kind) for kind, _ in KINDS]
        times = ["never" if gain is None else f"{gain:.3g} times sooner" for gain in both]
        parts.append(
            f"{robot_title(comparison.robot)}: {ends[NEW]} mm / deg with the new losses against "
            f"{ends[FORMER]} with the former after {comparison.epochs} epochs; the new ones reach "
            f"the former's final position error {times[0]}, its rotation error {times[1]}."
        )
    parts.append(
        "Both have equal weights, which favours one of them (the new rotation loss sums four "
        "components, the former averages them), and neither is trained for 100 epochs: this does "
        "not test the paper's claim of ten epochs instead of 100 to 300."
    )
    return " ".join(parts)


@dataclass(frozen=True)
class Ended:
    """One loss of a comparison, with the errors of its runs after the last step."""

    comparison: LossComparison
    loss: str

    @property
    def robot(self) -> str:
        """Name of the robot."""
        return self.comparison.robot

    def last(self, kind: str) -> pd.Series:
        """Return a kind of error of every run."""
        return self.comparison.curves[self.loss, kind].iloc[-1]


def _over_runs(kind: str, statistic: str) -> Callable[[Ended], float]:
    return lambda line: line.last(kind).agg(statistic)


STATISTICS = {"mean": "mean", "least": "min", "largest": "max"}
COLUMNS = (
    ROBOT,
    text("loss", "Losses", convert=TITLES.get),
    count("runs", "runs", lambda line: line.comparison.runs(line.loss)),
    count("epochs", "epochs", lambda line: line.comparison.epochs),
    *(
        Column(f"{kind}_{what}", what, label, _over_runs(kind, statistic), float, 3)
        for kind, label in KINDS
        for what, statistic in STATISTICS.items()
    ),
)


def losses_table(found: list[LossComparison]) -> Table:
    """Final errors by robot and loss, mean and range over the runs."""
    return Table.of(
        [Ended(comparison, loss) for comparison in found for loss in TITLES],
        COLUMNS,
        name="losses",
        title="Former and new losses at equal steps",
        caption="Mean Euclidean and geodesic errors on the validation set after the last step, "
        "mean and range over the runs. " + (verdict(found) if found else ""),
    )


def _curves(runs: list[SweptRun], kind: str) -> pd.DataFrame:
    """One kind of validation errors: index samples, a column a run."""
    columns = [run.curve.set_index("samples")[kind].dropna() for run in runs if kind in run.curve]
    return pd.concat(columns, axis=1).dropna() if columns else pd.DataFrame()


TOPIC = Topic(
    stages=("sweep",),
    tables=(lambda data: losses_table(compare_losses(data.results.swept)),),
    plots=(
        Plot(
            "losses",
            lambda data: (
                "Former and new losses at equal steps: mean of the runs, and from the "
                f"smallest to the largest. {verdict(compare_losses(data.results.swept))}"
            ),
            lambda data: compare_losses(data.results.swept),
            lambda data: losses_figure(compare_losses(data.results.swept)),
        ),
    ),
)
