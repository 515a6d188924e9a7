"""Figures of a study: history, importance, parallel coordinates, and one slice a parameter."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from numpy.typing import NDArray
from optuna import Study
from optuna.distributions import BaseDistribution, CategoricalDistribution
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
from optuna.trial import FrozenTrial, TrialState

from pipeline.presentation.naming import robot_title
from pipeline.presentation.style import (
    INK,
    LOOKS,
    PAPER_COLOUR,
    SOFT,
    logarithmic,
    panels,
    save,
    styled,
)

DARK, BRIGHT = LOOKS[0].colour, LOOKS[1].colour
DPI = 150
FEWEST = 4  # complete trials, below which there is nothing to compare
BEST_SHARE = 0.25  # of the trials, drawn above the others
COLOURS, ORDER_COLOURS = "viridis", "Blues"


def write_figures(study: Study, folder: Path, robot: str) -> None:
    """Write the figures that the complete trials allow, as PNG and PDF each."""
    title = robot_title(robot)
    complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if not complete:
        return
    pruned = study.get_trials(deepcopy=False, states=(TrialState.PRUNED,))
    with styled():
        save(_history(complete, pruned, title), folder, "history", DPI)
        if len(complete) >= FEWEST:
            save(_importance(study, title), folder, "importance", DPI)
            save(_parallel_coordinates(complete, title), folder, "parallel_coordinates", DPI)
            save(_slices(complete, title), folder, "slices", DPI)


def _history(complete: list[FrozenTrial], pruned: list[FrozenTrial], title: str) -> Figure:
    numbers, values = [trial.number for trial in complete], _objectives(complete)
    figure, (axes,) = panels(1, 5, 3)
    axes.plot(numbers, values, "o", color=PAPER_COLOUR, label="trial")
    if pruned:
        top = [float(values.max())] * len(pruned)
        axes.plot([trial.number for trial in pruned], top, "x", color=BRIGHT, label="cut short")
    axes.step(numbers, np.minimum.accumulate(values), where="post", color=DARK, label="best so far")
    axes.set(xlabel="trial", ylabel="objective", title=f"Search on {title}")
    logarithmic(axes, "y")
    axes.legend()
    return figure


def _importance(study: Study, title: str) -> Figure:
    with warnings.catch_warnings():  # few trials: the figure says how many
        warnings.simplefilter("ignore")
        shares = get_param_importances(study, evaluator=PedAnovaImportanceEvaluator())
    names = list(shares)[::-1]
    figure, (axes,) = panels(1, 5, 0.3 * len(names) + 1)
    axes.barh([_label(name) for name in names], [shares[name] for name in names], color=DARK)
    count = len(study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)))
    axes.set(xlabel=f"importance (PED-ANOVA, {count} trials)", title=f"Search on {title}")
    return figure


def _parallel_coordinates(complete: list[FrozenTrial], title: str) -> Figure:
    """A line a trial across one axis a parameter; the best quarter lies above the others."""
    names = _names(complete)
    figure, (axes,) = panels(1, max(1.15 * (len(names) + 1), 6), 3.4)
    values = _objectives(complete)
    norm = LogNorm(values.min(), max(values.max(), values.min() * 1.01))
    colours = ScalarMappable(norm, COLOURS)
    order = np.argsort(-values, kind="stable")
    heights = np.stack([_heights(complete, name) for name in names], axis=1)
    best = max(1, round(BEST_SHARE * len(complete)))
    for place, index in enumerate(order):
        above = place >= len(order) - best
        drawn = np.flatnonzero(np.isfinite(heights[index]))  # a line skips what was not drawn
        axes.plot(
            drawn,
            heights[index][drawn],
            color=colours.to_rgba(values[index]),
            linewidth=1.6 if above else 0.7,
            alpha=1.0 if above else 0.5,
        )
    for place, name in enumerate(names):
        axes.axvline(place, color=SOFT, linewidth=0.8)
        for text, height in zip(_ends(complete, name), (-0.03, 1.03), strict=True):
            align = "top" if height < 0 else "bottom"
            axes.text(place, height, text, ha="center", va=align, fontsize=7, color=INK)
    axes.set_xticks(range(len(names)), [_label(name) for name in names], rotation=30, ha="right")
    axes.set(ylim=(-0.12, 1.12), yticks=[], title=f"Search on {title}: the best quarter in bold")
    axes.grid(False)
    scale = figure.colorbar(colours, ax=axes, label="objective")
    scale.ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    scale.ax.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.3g}"))
    scale.ax.yaxis.set_minor_formatter(NullFormatter())
    if values.max() < 2 * values.min():  # no decade to divide
        scale.set_ticks(np.linspace(values.min(), values.max(), 4).tolist())
    return figure


def _slices(complete: list[FrozenTrial], title: str) -> Figure:
    """The objective over each parameter alone, the later a trial the darker."""
    names = _names(complete)
    figure, axes = panels(len(names), 2.3, 2.0, columns=4)
    for axis, name in zip(axes, names, strict=True):
        drew = [trial for trial in complete if name in trial.params]
        axis.scatter(
            _places(drew, name),
            _objectives(drew),
            c=[trial.number for trial in drew],
            vmin=0,
            vmax=complete[-1].number,
            cmap=ORDER_COLOURS,
            edgecolors=SOFT,
            linewidths=0.4,
            s=18,
        )
        _scale(axis, complete, name)
        axis.set_xlabel(_label(name))
        logarithmic(axis, "y")
    for axis in axes[::4]:
        axis.set_ylabel("objective")
    figure.suptitle(f"Search on {title}")
    order = ScalarMappable(Normalize(0, complete[-1].number), ORDER_COLOURS)
    figure.colorbar(order, ax=axes, label="trial", fraction=0.02)
    return figure


def _scale(axis: Axes, complete: list[FrozenTrial], name: str) -> None:
    distribution = _distribution(complete, name)
    if isinstance(distribution, CategoricalDistribution):
        choices = distribution.choices
        axis.set_xticks(range(len(choices)), [str(choice) for choice in choices])
    elif distribution.log:
        logarithmic(axis, "x")


def _objectives(trials: Sequence[FrozenTrial]) -> NDArray[np.float64]:
    return np.array([trial.value for trial in trials], dtype=float)


def _names(trials: Sequence[FrozenTrial]) -> list[str]:
    """Parameters in the order in which the deepest trial drew them, then what only others drew."""
    deepest = sorted(trials, key=lambda trial: -len(trial.params))
    return list(dict.fromkeys(name for trial in deepest for name in trial.params))


def _distribution(trials: Sequence[FrozenTrial], name: str) -> Any:
    return next(trial.distributions[name] for trial in trials if name in trial.params)


def _places(trials: Sequence[FrozenTrial], name: str) -> NDArray[np.float64]:
    """Values of a parameter, those of a choice by their number; NaN where it was not drawn."""
    distribution: BaseDistribution = _distribution(trials, name)
    kept = isinstance(distribution, CategoricalDistribution)
    return np.array(
        [
            np.nan
            if name not in trial.params
            else distribution.to_internal_repr(trial.params[name])
            if kept
            else trial.params[name]
            for trial in trials
        ],
        dtype=float,
    )


def _heights(trials: Sequence[FrozenTrial], name: str) -> NDArray[np.float64]:
    """Places of the trials between the ends of an axis, 0 to 1."""
    places = _places(trials, name)
    if getattr(_distribution(trials, name), "log", False):
        places = np.log(places)
    low, high = np.nanmin(places), np.nanmax(places)
    return (places - low) / (high - low) if high > low else places * 0 + 0.5


def _ends(trials: Sequence[FrozenTrial], name: str) -> tuple[str, str]:
    """What stands at the lower and upper end of an axis."""
    drawn = [trial.params[name] for trial in trials if name in trial.params]
    if isinstance(_distribution(trials, name), CategoricalDistribution):
        order = sorted(zip(_places(trials, name), range(len(trials)), strict=True))
        first, last = order[0][1], order[-1][1]
        return str(trials[first].params[name]), str(trials[last].params[name])
    return _number(min(drawn)), _number(max(drawn))


def _number(value: float) -> str:
    return f"{value:,}" if isinstance(value, int) else f"{value:.3g}"


def _label(name: str) -> str:
    return name.replace("_", " ")
