"""How figures look: legible in grey and for colour-blind readers, the same bytes every time."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from pipeline.data.files import replacing
from pipeline.presentation.naming import ordered_robots, ordered_solvers, robot_title

INK, SOFT = "#1f2933", "#7b8794"
COLUMNS = 3  # panels side by side: a robot each
ENTRY = 1.5  # inch: the longest entry of a legend
NARROWEST = 4.2  # inch: a single panel and the legend below it
PAPER_COLOUR = "#9aa5b1"  # whatever is published, not measured here
SETTINGS = Path(__file__).with_name("figures.mplstyle")


@dataclass(frozen=True)
class Look:
    """Colour, marker and line of one solver: any of the three tells it from the others."""

    colour: str
    marker: str
    line: str | tuple[int, tuple[float, ...]]


# Colours of Okabe and Ito (2008), ordered so that neighbours differ in lightness too.
LOOKS = (
    Look("#0b3c5d", "o", "-"),
    Look("#d55e00", "s", (0, (5, 1.5))),
    Look("#56b4e9", "^", (0, (1, 1))),
    Look("#009e73", "D", (0, (4, 1.2, 1, 1.2))),
    Look("#e69f00", "v", (0, (7, 1.5))),
    Look("#cc79a7", "P", (0, (3, 1, 1, 1, 1, 1))),
    Look("#6b4c9a", "X", (0, (2, 2))),
    Look("#3d3d3d", "<", (0, (9, 2, 2, 2))),
    Look("#a6761d", ">", (0, (1, 2))),
    Look("#66a61e", "h", (0, (6, 1, 1, 1))),
    Look("#8c1c13", "p", (0, (8, 3))),
    Look("#1b9aaa", "*", (0, (3, 3))),
    Look("#7f7f7f", "d", (0, (5, 1, 1, 1, 1, 1))),
    Look("#f2a3b3", "8", (0, (1, 4))),
)


def looks(solvers: Iterable[str]) -> dict[str, Look]:
    """Give each solver a look of its own, the same in every figure of a report."""
    return {name: LOOKS[i % len(LOOKS)] for i, name in enumerate(ordered_solvers(solvers))}


@contextmanager
def styled() -> Iterator[None]:
    """Draw with the settings of this project, whatever the user's matplotlibrc says."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rc_file(SETTINGS, use_default_template=False)
        yield


def panels(
    count: int, width: float, height: float, columns: int = COLUMNS
) -> tuple[Figure, list[Axes]]:
    """Make a figure of panels, row by row, without the drawing surface of a screen.

    Args:
        count: Number of panels.
        width: Width of a panel [inch].
        height: Height of a panel [inch].
        columns: Panels side by side at most.

    Returns:
        The figure and its axes.
    """
    columns = min(count, columns)
    rows = -(-count // columns)
    size = (max(width * columns, NARROWEST), height * rows)
    figure = Figure(figsize=size, layout="constrained")
    axes = [axis for row in figure.subplots(rows, columns, squeeze=False) for axis in row]
    for axis in axes[count:]:
        axis.remove()
    return figure, axes[:count]


def robot_panels(
    robots: Iterable[str], width: float, height: float, columns: int = COLUMNS
) -> tuple[Figure, dict[str, Axes]]:
    """Make a figure with a panel a robot, titled with it, in the order of all figures.

    Args:
        robots: Names of robots, each any number of times.
        width: Width of a panel [inch].
        height: Height of a panel [inch].
        columns: Panels side by side at most.

    Returns:
        The figure and its axes by robot.
    """
    names = ordered_robots(robots)
    figure, axes = panels(len(names), width, height, columns)
    for name, axis in zip(names, axes, strict=True):
        axis.set_title(robot_title(name))
    return figure, dict(zip(names, axes, strict=True))


def label_first_column(axes: Iterable[Axes], label: str) -> None:
    """Label the vertical axis once a row."""
    for axis in axes:
        place = axis.get_subplotspec()
        if place is not None and place.is_first_col():
            axis.set_ylabel(label)


def logarithmic(axis: Axes, which: Literal["x", "y"]) -> None:
    """Make an axis logarithmic with plain numbers, enough of them where it is short.

    To be called when everything is drawn: what is labelled depends on the range.
    """
    (axis.set_xscale if which == "x" else axis.set_yscale)("log")
    low, high = axis.get_xlim() if which == "x" else axis.get_ylim()
    steps = (1.0, 2.0, 5.0) if high < 150 * low else (1.0,)
    ticks = axis.xaxis if which == "x" else axis.yaxis
    ticks.set_major_locator(LogLocator(subs=steps, numticks=6 if len(steps) == 1 else None))
    ticks.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    ticks.set_minor_formatter(NullFormatter())


def reference_line(axis: Axes, which: Literal["x", "y"], value: float, label: str) -> None:
    """Draw a dashed line through a value to compare with, across the whole panel.

    Args:
        axis: The panel.
        which: Axis that the value is on.
        value: In the unit of the axis.
        label: Of the line in the legend.
    """
    draw = axis.axvline if which == "x" else axis.axhline
    draw(value, color=PAPER_COLOUR, linestyle="--", label=label)


def legend_below(
    figure: Figure, axes: Iterable[Axes], columns: int = 5, label: str | None = None
) -> None:
    """Put one legend for all panels under them, each entry once, in as many columns as fit.

    Args:
        figure: The figure.
        axes: Its panels.
        columns: Entries side by side at most.
        label: Of the vertical axes, written once a row; None leaves them as they are.
    """
    axes = list(axes)
    if label is not None:
        label_first_column(axes, label)
    found: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            found.setdefault(label, handle)
    if found:
        figure.legend(
            list(found.values()),
            list(found),
            loc="outside lower center",
            ncols=max(min(columns, len(found), int(figure.get_figwidth() / ENTRY)), 1),
        )


def save(figure: Figure, folder: Path, name: str, dpi: int) -> list[Path]:
    """Write a figure as PNG and PDF without dates, so that equal figures are equal files."""
    paths = []
    # Lay out once, not again for each file.
    figure.draw_without_rendering()
    figure.set_layout_engine("none")
    for suffix, metadata in (("png", {"Software": None}), ("pdf", {"CreationDate": None})):
        path = folder / f"{re.sub(r'[^a-z0-9_]+', '_', name.lower())}.{suffix}"
        with replacing(path) as partial:
            figure.savefig(partial, dpi=dpi, metadata=metadata)
        paths.append(path)
    return paths
