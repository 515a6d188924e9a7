"""What the success of grasp trials depends on: object, place, and settings that were varied."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from pipeline.presentation.columns import ROBOT, count, number, plain, text, under
from pipeline.presentation.naming import OUTCOMES, ordered_robots, robot_title, solver_title
from pipeline.presentation.style import LOOKS, SOFT, label_first_column, legend_below, panels
from pipeline.presentation.table import Table
from pipeline.reporting.config import ReportConfig
from pipeline.reporting.data import Plot, Topic
from pipeline.reporting.results import Results
from pipeline.reporting.topics.outcomes import SUCCESS_COLUMNS, Counted, intervals

CLASSES = tuple(OUTCOMES.values())
COLOURS = ("#0b3c5d", "#e69f00", "#d55e00", "#cc79a7", "#6b4c9a")  # a class each, as in CLASSES
# Settings that a study varies: their column in the raw rows, and how a value is called.
AXES = {
    "solver": ("solver", "solver"),
    "position_error": ("position_error_mm", "position error [mm]"),
    "tension_scale": ("tension_scale", "tension [times the scene's]"),
    "friction_scale": ("friction_scale", "friction [times the scene's]"),
    "rate": ("rate_hz", "rate [Hz]"),
    "iterations": ("iterations", "solver iterations"),
    "noise_seed": ("noise_seed", "seed of the placement noise"),
    "zero_offset": ("zero_offset_deg", "zeros of the joints [deg]"),
    "backlash": ("backlash_deg", "play of the joints [deg]"),
    "mass_spread": ("mass_spread", "spread of the masses [log]"),
}
PLACE = {"object", "row", "x_m", "y_m"}
SIDES = {True: "left", False: "right"}  # of the middle of what was laid, seen by the robot
FAILURES = under(
    "failures",
    count("slipped", "slipped", lambda line: line.ended("slipped")),
    count("not_grasped", "not grasped", lambda line: line.ended("not_grasped")),
)


def grasp_objects(results: Results, config: ReportConfig) -> Table:
    """Success by object, by row of the action area and by side."""
    lines = []
    for robot, trials in with_places(results.grasp).items():
        middle = 0.5 * (trials["y_m"].min() + trials["y_m"].max())
        groups = {
            "object": trials["object"].map(plain),
            "row": trials["row"] + 1,
            "side": (trials["y_m"] > middle).map(SIDES),
        }
        lines += [
            Counted(robot, "success", part, config.confidence, of=str(value), by=by)
            for by, keys in groups.items()
            for value, part in trials.groupby(keys, sort=True)
        ]
    return Table.of(
        lines,
        (ROBOT, text("by", "by"), text("value", "value", "of"), *SUCCESS_COLUMNS),
        name="grasp_success_by",
        title="Success by object and by position",
        caption=f"Share of trials that succeeded with {config.confidence * 100:g} % Wilson "
        "intervals. Rows are counted from the near side; sides are as the robot sees them.",
    )


def grasp_studies(results: Results, config: ReportConfig) -> Table:
    """Success of every variant of every study."""
    lines = []
    for robot, study in _studies(results.grasp_studies):
        rows = results.grasp_studies[robot, study]
        axes = study_axes(rows)
        for values, part in rows.groupby([AXES[axis][0] for axis in axes], sort=False):
            named = [_called(axis, value) for axis, value in zip(axes, values, strict=True)]
            variant = ", ".join(named)
            lines.append(
                Counted(robot, "success", part, config.confidence, of=variant, by=plain(study))
            )
    return Table.of(
        lines,
        (
            text("study", "Study", "by"),
            ROBOT,
            text("variant", "variant", "of"),
            *SUCCESS_COLUMNS,
            *FAILURES,
            number("plan_ms", "plan [ms]", lambda line: line.rows["approach_plan_ms"].median()),
        ),
        name="grasp_studies",
        title="What a grasp depends on",
        caption="The same trials with one or two settings varied; shares with "
        f"{config.confidence * 100:g} % Wilson intervals. Plan time: median of the approach.",
    )


def grasp_places(grasps: Mapping[str, pd.DataFrame], config: ReportConfig) -> Figure:
    """Every trial where its object lay, and the share of success by object."""
    robots = ordered_robots(grasps)
    figure, axes = panels(2 * len(robots), 4.2, 2.6, columns=2)
    for k, robot in enumerate(robots):
        trials, (plane, bars) = grasps[robot], axes[2 * k : 2 * k + 2]
        for name, colour in zip(CLASSES, COLOURS, strict=True):
            part = trials[trials["class"] == name]
            if len(part):
                marker = "o" if name == CLASSES[0] else "X"
                plane.plot(part["y_m"], part["x_m"], marker, color=colour, label=name)
        plane.invert_xaxis()  # the robot looks up: its left is on the left
        plane.set(title=robot_title(robot), xlabel="y [m]", ylabel="x, away from the robot [m]")
        names = list(dict.fromkeys(trials["object"].sort_values()))
        _whiskers(bars, np.arange(len(names), dtype=float), trials, "object", names, config)
        bars.set_xticks(range(len(names)), [name.replace("_", "\n") for name in names])
        bars.set(ylim=(0, 104), xlim=(-0.5, len(names) - 0.5), ylabel="success [%]")
    legend_below(figure, axes)
    return figure


def study_charts(studies: Mapping[tuple[str, str], pd.DataFrame], config: ReportConfig) -> Figure:
    """Success of the variants of each study: points for one setting, a map for two."""
    keys = _studies(studies)
    figure, axes = panels(len(keys), 3.6, 2.9)
    for axis, (robot, study) in zip(axes, keys, strict=True):
        rows = studies[robot, study]
        varied = study_axes(rows)
        if len(varied) == 2:
            _map(axis, rows, varied)
        else:
            _points(axis, rows, varied[0], config)
        axis.set_title(f"{robot_title(robot)}: {plain(study)}")
    label_first_column([axis for axis in axes if not axis.images], "success [%]")
    return figure


def with_places(grasps: Mapping[str, pd.DataFrame]) -> dict[str, pd.DataFrame]:
    """Trials of the robots whose rows say what lay where, robots in the order of all tables."""
    placed = {robot: rows for robot, rows in grasps.items() if set(rows.columns) >= PLACE}
    return {robot: placed[robot] for robot in ordered_robots(placed)}


def study_axes(rows: pd.DataFrame) -> list[str]:
    """Settings that a study's rows were varied in."""
    return [axis for axis in str(rows["axes"].iloc[0]).split(",") if axis in AXES]


def _studies(studies: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Robots and studies, by study."""
    return sorted(studies, key=lambda key: (key[1], key[0]))


def _called(axis: str, value: object) -> str:
    return solver_title(str(value)) if axis == "solver" else f"{AXES[axis][1]} {value:g}"


def _points(axis: Axes, rows: pd.DataFrame, varied: str, config: ReportConfig) -> None:
    column, label = AXES[varied]
    values = list(dict.fromkeys(rows[column]))
    if varied == "solver":
        places = np.arange(len(values), dtype=float)
        names = [solver_title(str(value)).replace(" ", "\n") for value in values]
        axis.set_xticks(places, names)
        axis.set_xlim(-0.5, len(values) - 0.5)
    else:
        places = np.array(values, dtype=np.float64)
        axis.set_xlabel(label)
    _whiskers(axis, places, rows, column, values, config)
    axis.set_ylim(0, 104)


def _whiskers(
    axis: Axes,
    places: NDArray[np.float64],
    rows: pd.DataFrame,
    column: str,
    values: list[object],
    config: ReportConfig,
) -> None:
    """Success of the trials with each value of a column, with Wilson intervals."""
    parts = [rows[rows[column] == value] for value in values]
    shares, reach = intervals(Counted("", "success", part, config.confidence) for part in parts)
    axis.errorbar(places, shares, yerr=reach, fmt="o", color=LOOKS[0].colour, ecolor=SOFT,
                  capsize=3, markersize=5)  # fmt: skip


def _map(axis: Axes, rows: pd.DataFrame, varied: list[str]) -> None:
    """Share of success for every pair of values, written into its field."""
    columns = [AXES[name][0] for name in varied]
    shares = rows.assign(success=100.0 * (rows["class"] == CLASSES[0])).pivot_table(
        index=columns[0], columns=columns[1], values="success", aggfunc="mean"
    )
    axis.imshow(shares.to_numpy(), vmin=0, vmax=100, cmap="cividis", aspect="auto", origin="lower")
    for (i, j), value in np.ndenumerate(shares.to_numpy()):
        colour = "white" if value < 60 else "black"
        axis.text(j, i, f"{value:.0f}", ha="center", va="center", color=colour, size=8)
    axis.set_yticks(range(len(shares.index)), [f"{level:g}" for level in shares.index])
    axis.set_xticks(range(len(shares.columns)), [f"{level:g}" for level in shares.columns])
    axis.set(ylabel=AXES[varied[0]][1], xlabel=AXES[varied[1]][1])
    axis.grid(visible=False)


TOPIC = Topic(
    stages=("grasp", "grasp_study"),
    tables=(
        lambda data: grasp_objects(data.results, data.config),
        lambda data: grasp_studies(data.results, data.config),
    ),
    plots=(
        Plot(
            "grasp_places",
            "Position of the object of each trial, seen from above with the robot below, and the "
            "outcome; success by object with Wilson intervals.",
            lambda data: with_places(data.results.grasp),
            lambda data: grasp_places(with_places(data.results.grasp), data.config),
        ),
        Plot(
            "grasp_studies",
            "The same trials with one or two settings varied: success with Wilson intervals, or "
            "in per cent on a map.",
            lambda data: data.results.grasp_studies,
            lambda data: study_charts(data.results.grasp_studies, data.config),
        ),
    ),
)
