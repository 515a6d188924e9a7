"""The figure: counts beside chances, the errors that explain them, the classes that each feeds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.hardware.chances import CLASSES
from benchmarks.hardware.errors import ERRORS
from benchmarks.hardware.tables import LAST_RUN, NONE_RUN, Robot, settings
from pipeline.presentation.naming import robot_title
from pipeline.presentation.style import INK, LOOKS, PAPER_COLOUR, SOFT, panels

COLOURS = {
    "published": PAPER_COLOUR,
    NONE_RUN: LOOKS[2].colour,
    "likely errors": LOOKS[0].colour,
    "nearest errors": LOOKS[0].colour,
    LAST_RUN: LOOKS[1].colour,
}
BAR = 0.8


def draw(robots: Sequence[Robot]) -> Figure:
    """Draw a line of three panels for each robot."""
    figure, axes = panels(3 * len(robots), 4.6, 3.4)
    for k, each in enumerate(robots):
        counts, errors, classes = axes[3 * k : 3 * k + 3]
        _outcomes(counts, each)
        _errors(errors, each)
        _sensitivity(classes, each)
    return figure


def _outcomes(axis: Axes, each: Robot) -> None:
    shown = [line for line in settings([each]) if line.name in COLOURS]
    width = BAR / len(shown)
    for k, line in enumerate(shown):
        at = np.arange(len(CLASSES)) + (k - 0.5 * (len(shown) - 1)) * width
        bars = axis.bar(at, 100 * line.chances, width, color=COLOURS[line.name], label=line.name)
        axis.bar_label(
            bars, [f"{100 * chance:.0f}" for chance in line.chances], color=INK, fontsize=8
        )
    axis.set_xticks(range(len(CLASSES)), CLASSES)
    axis.set_ylabel("trials [%]")
    axis.set_ylim(0, 115)
    axis.set_title(f"{robot_title(each.robot)}: outcomes")
    axis.legend(loc="upper right", fontsize=8)


def _errors(axis: Axes, each: Robot) -> None:
    """Shares of the ranges: what is not contradicted, the smallest errors, each alone."""
    found, places = each.found, np.arange(len(ERRORS))[::-1]
    axis.hlines(places, 0, 1, color=SOFT, linewidth=0.8, linestyle=":")
    axis.hlines(
        places,
        *found.ranges,
        color=LOOKS[2].colour,
        linewidth=7,
        alpha=0.6,
        label="not contradicted",
    )
    axis.hlines(places, *found.spread, color=INK, linewidth=1.5, label="smallest, 90 % of refits")
    axis.plot(found.smallest, places, "o", color=LOOKS[0].colour, label="smallest, all together")
    axis.plot(found.best, places, "s", color=LOOKS[3].colour, label=f"{each.best}, all together")
    alone = [one.share for one in found.alone]
    axis.plot(alone, places, "D", color=LOOKS[1].colour, label="smallest, alone")
    axis.set_yticks(places, [error.title for error in ERRORS])
    ends = [f"{error.said(0):g} to {error.said(1):g}" for error in ERRORS]
    for place, words in zip(places, ends, strict=True):
        axis.text(1.02, place, words, va="center", fontsize=8, color=INK)
    axis.set_xlim(-0.03, 1.35)
    axis.set_xticks([0, 0.5, 1])
    axis.set_xlabel("share of the range that was tried")
    axis.set_title(f"{robot_title(each.robot)}: errors that explain them")
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, fontsize=8)


def _sensitivity(axis: Axes, each: Robot) -> None:
    change = 100 * each.found.sensitivity(each.found.best)
    most = max(float(np.abs(change).max()), 1.0)
    axis.imshow(change, cmap="RdBu", vmin=-most, vmax=most, aspect="auto")
    for row in range(len(ERRORS)):
        for column in range(len(CLASSES)):
            value = change[row, column]
            colour = "white" if abs(value) > 0.6 * most else INK
            axis.text(column, row, f"{value:+.1f}", ha="center", va="center", color=colour)
    axis.set_xticks(range(len(CLASSES)), CLASSES)
    axis.set_yticks(range(len(ERRORS)), [error.title for error in ERRORS])
    axis.grid(visible=False)
    axis.set_title(f"{robot_title(each.robot)}: points for a tenth more")
