"""Figures of a study: how the objective fell, and which parameter mattered."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from optuna import Study
from optuna.importance import PedAnovaImportanceEvaluator, get_param_importances
from optuna.trial import TrialState

from pipeline.data.files import replacing

GREY, DARK = "#8c8c8c", "#1b4965"


def write_figures(study: Study, folder: Path, title: str) -> None:
    """Write history.png and, where enough trials ended, importance.png."""
    complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    if not complete:
        return
    numbers = [trial.number for trial in complete]
    values = np.array([trial.value for trial in complete], dtype=float)
    figure, axes = plt.subplots(figsize=(5, 3), layout="constrained")
    axes.plot(numbers, values, "o", color=GREY, label="trial")
    axes.step(numbers, np.minimum.accumulate(values), where="post", color=DARK, label="best so far")
    axes.set(xlabel="trial", ylabel="objective", title=f"Search on {title}")
    axes.legend(frameon=False)
    _save(figure, folder / "history.png")
    if len(complete) < 4:
        return
    shares = get_param_importances(study, evaluator=PedAnovaImportanceEvaluator())
    names = list(shares)[::-1]
    figure, axes = plt.subplots(figsize=(5, 0.3 * len(names) + 1), layout="constrained")
    axes.barh(names, [shares[name] for name in names], color=DARK)
    axes.set(xlabel="share of the objective's variance", title=f"Importance on {title}")
    _save(figure, folder / "importance.png")


def _save(figure: plt.Figure, path: Path) -> None:
    with replacing(path) as partial:
        figure.savefig(partial, dpi=150)
    plt.close(figure)
