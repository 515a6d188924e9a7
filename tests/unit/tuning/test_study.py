"""Studies: stopped anywhere they go on, no draw repeats, lost trials are made up for."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest
from optuna import Trial
from optuna.trial import TrialState

from pipeline.config import compose
from pipeline.errors import PipelineError
from pipeline.settings import Config
from pipeline.tuning.objective import draw
from pipeline.tuning.study import open_study, run_trials, study_name, trials_table


@cache
def config(*overrides: str) -> Config:
    return compose(["profile=smoke", "robot=nico", "tune.trials=6", *overrides])


def objective(trial: Trial) -> float:
    train, model = draw(trial, config())
    return train.learning_rate * 1e3 + sum(model.hidden)


def test_a_study_that_is_stopped_draws_what_an_uninterrupted_one_draws(tmp_path: Path) -> None:
    whole = open_study(tmp_path / "whole.log", config())
    run_trials(whole, objective, config())
    for total in (2, 5, 6):
        parts = open_study(tmp_path / "parts.log", config(f"tune.trials={total}"))
        run_trials(parts, objective, config(f"tune.trials={total}"))
    first, second = trials_table(whole), trials_table(parts)
    assert len(first) == 6
    assert first.equals(second)
    assert first["learning_rate"].nunique() == 6


def test_a_trial_that_was_cut_off_fails_and_is_made_up_for(tmp_path: Path) -> None:
    study = open_study(tmp_path / "study.log", config())
    study.ask()  # what a killed process leaves: a trial that runs for ever
    study = open_study(tmp_path / "study.log", config())
    run_trials(study, objective, config())
    states = [trial.state for trial in study.get_trials()]
    assert states.count(TrialState.COMPLETE) == 6
    assert states.count(TrialState.FAIL) == 1
    assert TrialState.RUNNING not in states


def test_failing_trials_never_end_the_study_but_a_hopeless_one_says_so(tmp_path: Path) -> None:
    def sometimes(trial: Trial) -> float:
        if trial.number % 2:
            raise RuntimeError("out of memory")
        return objective(trial)

    study = open_study(tmp_path / "some.log", config())
    run_trials(study, sometimes, config())
    assert len(study.get_trials(states=(TrialState.COMPLETE,))) == 6

    def never(trial: Trial) -> float:
        return float("nan")

    with pytest.raises(PipelineError, match=r"failed: look at tune\.space"):
        run_trials(open_study(tmp_path / "none.log", config()), never, config())


def test_another_space_or_seed_is_another_study() -> None:
    names = {
        study_name(config(*overrides))
        for overrides in ([], ["tune.space.layers.high=4"], ["seed=1"], ["train.loss=former"])
    }
    assert len(names) == 4
    assert study_name(config("tune.trials=99")) in names


def test_draws_lie_in_the_space_and_keep_their_types(tmp_path: Path) -> None:
    study = open_study(tmp_path / "study.log", config())
    for _ in range(20):
        train, model = draw(study.ask(), config())
        assert 50 <= train.batch_size <= 200
        assert train.batch_size % 50 == 0
        assert 1e-3 <= train.learning_rate <= 3e-2
        assert 1 <= len(model.hidden) <= 3
        assert all(isinstance(neurons, int) for neurons in model.hidden)
        assert train.epochs == config().tune.epochs
