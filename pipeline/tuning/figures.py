"""Figures of a study: how the objective fell, and which parameter mattered."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from optuna import Study
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
from optuna.trial import FrozenTrial, TrialState

from pipeline.reporting.style import LOOKS, PAPER_COLOUR, panels, save, styled

DARK = LOOKS[0].colour
DPI = 150


def write_figures(study: Study, folder: Path, title: str) -> None:
    """Write history and, where enough trials ended, importance, as PNG and PDF each."""
    complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if not complete:
        return
    with styled():
        save(_history(complete, title), folder, "history", DPI)
        if len(complete) >= 4:
            save(_importance(study, title), folder, "importance", DPI)


def _history(complete: list[FrozenTrial], title: str) -> Figure:
    numbers = [trial.number for trial in complete]
    values = np.array([trial.value for trial in complete], dtype=float)
    figure, (axes,) = panels(1, 5, 3)
    axes.plot(numbers, values, "o", color=PAPER_COLOUR, label="trial")
    axes.step(numbers, np.minimum.accumulate(values), where="post", color=DARK, label="best so far")
    axes.set(xlabel="trial", ylabel="objective", title=f"Search on {title}")
    axes.legend()
    return figure


def _importance(study: Study, title: str) -> Figure:
    shares = get_param_importances(study, evaluator=PedAnovaImportanceEvaluator())
    names = list(shares)[::-1]
    figure, (axes,) = panels(1, 5, 0.3 * len(names) + 1)
    axes.barh(names, [shares[name] for name in names], color=DARK)
    axes.set(xlabel="share of the objective's variance", title=f"Importance on {title}")
    return figure
