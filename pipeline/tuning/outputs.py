"""What a study leaves: its trials as CSV, the best one as YAML, figures, a table like Table I."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd
from omegaconf import OmegaConf
from optuna import Study
from optuna.trial import FrozenTrial, TrialState

from pipeline.artifacts import SIGNATURE
from pipeline.containers import to_dict
from pipeline.data.files import sha256, write_json, write_sealed_json, write_sealed_yaml, write_text
from pipeline.errors import PipelineError
from pipeline.locations import published_results
from pipeline.presentation.origin import origin_of
from pipeline.presentation.published import read_published
from pipeline.presentation.table import Table
from pipeline.provenance import made_by, signature
from pipeline.tuning.figures import write_figures
from pipeline.tuning.hyperparameters import Hyperparameters, found_hyperparameters
from pipeline.tuning.journal import WORKER
from pipeline.tuning.sampling import DRAW
from pipeline.tuning.space import draw
from pipeline.tuning.study import ABANDONED, REASON, START, count

if TYPE_CHECKING:
    from pipeline.settings import Config

MADE_BY = "# The best trial of `python -m pipeline tune`; `train.from=best` takes it.\n"
PUBLISHED = published_results()
SHAPE = ("hidden", "tanh_layers")  # reported of every network
SHOWN = 3  # best trials in the table
TRIALS, BEST, METRICS = "trials.csv", "best.yaml", "metrics.json"
CARD = "card.json"  # checksums of the files beside it


def write_outputs(study: Study, folder: Path, config: Config) -> None:
    """Write trials.csv, best.yaml, metrics.json, figures, a table like Table I, and last a card.

    Raises:
        PipelineError: No trial ended well.
    """
    folder.mkdir(parents=True, exist_ok=True)
    write_trials(study, folder)
    if not study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,)):
        raise PipelineError(f"no trial of {study.study_name} ended well: look at tune.space")
    found = OmegaConf.create(best(study, config))
    write_sealed_yaml(folder / BEST, MADE_BY + OmegaConf.to_yaml(found))
    tally = count(study)
    metrics = {
        "objective": study.best_value,
        "trials": tally.finished,
        "requested": config.tune.trials,
        "failed": tally.failed,
    }
    write_json(folder / METRICS, metrics)
    write_figures(study, folder, config.robot.name)
    signed = {**made_by(), **signature(config.profile), "seed": config.seed}
    write_json(folder / SIGNATURE, signed)
    table = _like_table_one(study, config)
    table.origin = origin_of(
        f"python -m pipeline tune robot={config.robot.name} profile={config.profile}", [signed]
    )
    table.write(folder)
    files = {name: sha256(folder / name) for name in (TRIALS, METRICS)}
    write_sealed_json(folder / CARD, {"study": study.study_name, "files": files})


def write_trials(study: Study, folder: Path) -> None:
    """Write trials.csv; a card that knows the former one goes before it."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / CARD).unlink(missing_ok=True)
    write_text(folder / TRIALS, trials_table(study).to_csv(index=False))


def trials_table(study: Study) -> pd.DataFrame:
    """Return one row for each trial: number, state, objective, drawn values, errors; no clock."""
    trials = study.get_trials(deepcopy=False)
    return pd.DataFrame([_row(trial) for trial in trials if trial.state != TrialState.WAITING])


def best(study: Study, config: Config) -> dict[str, Any]:
    """Return what the best trial drew, by group, and what it is the best of."""
    trial = study.best_trial
    train, model = (to_dict(group) for group in draw(trial, config))
    searched = list(config.tune.space)
    return {
        "train": {key: train[key] for key in searched if key in train},
        "model": {key: model[key] for key in dict.fromkeys([*searched, *SHAPE]) if key in model},
        "of": {
            "study": study.study_name,
            "robot": config.robot.name,
            "model": config.model.name,
            "kind": config.model.kind,
            "trial": trial.number,
            "objective": trial.value,
        },
    }


def _like_table_one(study: Study, config: Config) -> Table:
    complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
    ranked = sorted(complete, key=lambda trial: (trial.value, trial.number))
    rows = {f"trial {trial.number}": trial for trial in ranked[:SHOWN]}
    rows |= {f"trial {t.number}, the start": t for t in complete if START in t.user_attrs}
    found = []
    for name, trial in rows.items():
        train, model = (to_dict(group) for group in draw(trial, config))
        parameters = trial.user_attrs.get("parameters")
        found.append(
            Hyperparameters(config.robot.name, name, train, model, parameters, trial.value)
        )
    return found_hyperparameters(config.robot.name, read_published(PUBLISHED), found)


def _row(trial: FrozenTrial) -> dict[str, Any]:
    attributes = {k: v for k, v in trial.user_attrs.items() if k not in (WORKER, START, DRAW)}
    if trial.state == TrialState.FAIL:
        attributes.setdefault(REASON, ABANDONED)  # Optuna fails those without a heartbeat mutely
    return {
        "number": trial.number,
        "state": trial.state.name,
        "objective": trial.value,
        "drawn": START not in trial.user_attrs,
        **trial.params,
        **attributes,
    }
