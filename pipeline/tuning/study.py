"""A study on disk that can be stopped anywhere and goes on to the number of trials asked for."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import optuna
import pandas as pd
from optuna import Study, Trial
from optuna.exceptions import ExperimentalWarning
from optuna.samplers import BaseSampler, RandomSampler, TPESampler
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from optuna.trial import TrialState

from pipeline.config import to_dict
from pipeline.errors import PipelineError
from pipeline.progress import bar
from pipeline.provenance import digest
from pipeline.seeding import derive_seed
from pipeline.settings import Config, TuneConfig

FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)
PATIENCE = 20  # failed trials beyond which a search counts as hopeless


def study_name(config: Config, data: str = "") -> str:
    """Return the name of a study: robot, model and a hash of everything that shapes a trial.

    Optuna takes a changed range silently; another name keeps trials of another space apart.

    Args:
        config: The configuration of the search.
        data: Digest of the pose sets.
    """
    shape = {**to_dict(config.tune), "trials": None}
    parts = [shape, to_dict(config.train), to_dict(config.model), data, config.seed]
    return f"{config.robot.name}-{config.model.name}-{digest(parts)}"


def open_study(path: Path, config: Config, data: str = "") -> Study:
    """Open the study of a journal file or start it; trials that a kill cut off become failures."""
    path.parent.mkdir(parents=True, exist_ok=True)
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    warnings.filterwarnings("ignore", category=ExperimentalWarning)
    study = optuna.create_study(
        study_name=study_name(config, data),
        storage=JournalStorage(JournalFileBackend(str(path))),
        direction="minimize",
        load_if_exists=True,
    )
    for trial in study.get_trials(deepcopy=False, states=(TrialState.RUNNING,)):
        study.tell(trial.number, state=TrialState.FAIL)
    return study


def run_trials(study: Study, objective: Callable[[Trial], float], config: Config) -> None:
    """Run trials until the study has ``tune.trials`` finished ones; failed ones are made up for.

    Every trial draws from a sampler seeded by its number, so a study that was stopped between two
    trials goes on as if it had not been, and no draw repeats.

    Raises:
        PipelineError: Trial after trial failed.
    """
    done = len(study.get_trials(deepcopy=False, states=FINISHED))
    with bar(config.tune.trials, "trial", f"tune {config.robot.name}", done) as shown:
        while done < config.tune.trials:
            number = len(study.get_trials(deepcopy=False))
            study.sampler = sampler(config.tune, derive_seed(config.seed, "sampler", number))
            study.optimize(objective, n_trials=1, catch=(RuntimeError, ValueError, MemoryError))
            done = len(study.get_trials(deepcopy=False, states=FINISHED))
            shown.update(done - shown.n)
            failed = study.get_trials(deepcopy=False, states=(TrialState.FAIL,))
            if len(failed) > PATIENCE + config.tune.trials:
                raise PipelineError(
                    f"{len(failed)} trials of {study.study_name} failed: look at tune.space"
                )


def sampler(tune: TuneConfig, seed: int) -> BaseSampler:
    """Return the sampler that ``tune.sampler`` names."""
    if tune.sampler == "random":
        return RandomSampler(seed=seed)
    return TPESampler(seed=seed, multivariate=True, group=True)


def trials_table(study: Study) -> pd.DataFrame:
    """Return one row for each trial: number, state, objective, drawn values, errors; no clock."""
    rows = []
    for trial in study.get_trials(deepcopy=False):
        row = {"number": trial.number, "state": trial.state.name, "objective": trial.value}
        rows.append({**row, **trial.params, **trial.user_attrs})
    return pd.DataFrame(rows)
