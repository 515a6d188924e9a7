"""A study that can be stopped anywhere and resumes to exactly the requested number of trials."""

from __future__ import annotations

import math
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import optuna
from optuna import Study, Trial
from optuna.exceptions import ExperimentalWarning
from optuna.trial import FrozenTrial, TrialState

from pipeline.containers import to_dict
from pipeline.errors import PipelineError
from pipeline.progress import LOGGER
from pipeline.provenance import digest
from pipeline.seeding import derive_seed
from pipeline.tuning.sampling import DRAW, make_pruner, make_sampler
from pipeline.tuning.space import starting_points
from pipeline.tuning.storage import Store

if TYPE_CHECKING:
    from pipeline.settings import Config

FINISHED = (TrialState.COMPLETE, TrialState.PRUNED)
# What a configuration can do to its trial: out of memory is a RuntimeError of torch, or this.
FAULTS = (RuntimeError, ValueError, MemoryError, ArithmeticError)
START, REASON = "start", "reason"  # attributes of trials
ABANDONED = "its worker died"
# How a study is run, not what its trials are: another value continues the same study.
RUNNING_OF_IT = ("trials", "workers", "storage", "heartbeat_s", "stop", "comparison")
POLL_S = 0.2
TrialObjective = Callable[[Trial], float]


@dataclass(frozen=True)
class Tally:
    """How far a study is.

    Attributes:
        finished: Complete and pruned trials.
        running: Trials that a living worker runs.
        failed: Failed trials.
        failed_in_a_row: Latest trials that failed without one between them that ended well; those
            whose worker was killed say nothing.
        stalled: Finished trials since the best one.
    """

    finished: int
    running: int
    failed: int
    failed_in_a_row: int
    stalled: int


def study_name(config: Config, data: str = "") -> str:
    """Return the name of a study: robot, model and a hash of everything that shapes a trial.

    Optuna takes a changed range silently; another name keeps trials of another space apart.

    Args:
        config: The configuration of the search.
        data: Digest of the pose sets.
    """
    shape = {k: v for k, v in to_dict(config.tune).items() if k not in RUNNING_OF_IT}
    parts = [shape, to_dict(config.train), to_dict(config.model), data, config.seed]
    return f"{config.robot.name}-{config.model.name}-{digest(parts)}"


def open_study(store: Store, config: Config, data: str = "") -> Study:
    """Open a study or start it, with its first trials queued, and fail those that were cut off."""
    # Optuna tells of a trial that failed, or that a signal ended, by a traceback.
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    warnings.filterwarnings("ignore", category=ExperimentalWarning)
    name = study_name(config, data)
    with store.claim(name):
        study = optuna.create_study(
            study_name=name,
            storage=store.storage,
            direction="minimize",
            pruner=make_pruner(config.tune.pruner),
            load_if_exists=True,
        )
        _bury(store, study)
        _queue_starts(study, config)
    for index, (_, problem) in enumerate(starting_points(config)):
        if problem:
            LOGGER.info("tune.start[%d] is left out: %s", index, problem)
    return study


def run_trials(
    store: Store,
    study: Study,
    objective: TrialObjective,
    config: Config,
    go_on: Callable[[], bool] = lambda: True,
) -> None:
    """Run trials until the study has ``tune.trials`` finished ones; failed ones are repeated.

    Any number of workers may do this at once. A worker claims the study, counts what is finished
    and what others run, and begins a trial only if those are too few; the last ones wait, in case a
    trial of another must be repeated. Every trial draws from a sampler seeded by its number among
    those that were not cut off, so no draw repeats, a trial that makes up for one that was cut off
    draws what that one drew, and one worker alone draws the same trials every time.

    Args:
        store: Where the study is kept.
        study: The study.
        objective: Returns what is minimised.
        config: Requested trials, sampler, seed.
        go_on: Called between trials.

    Raises:
        PipelineError: Trial after trial failed.
    """
    while go_on():
        with store.claim(study.study_name) as release:
            _bury(store, study)
            _queue_starts(study, config)
            tally = count(study)
            if is_over(tally, config):
                return
            if tally.finished + tally.running < config.tune.trials:
                _one(store, study, objective, config, release)
                continue
        time.sleep(POLL_S)


def is_over(tally: Tally, config: Config) -> bool:
    """Whether a study has its requested trials, or no longer improves.

    Raises:
        PipelineError: Trial after trial failed.
    """
    stop = config.tune.stop
    if tally.finished >= config.tune.trials:
        return True
    if stop.failures and tally.failed_in_a_row >= stop.failures:
        raise PipelineError(
            f"{tally.failed_in_a_row} trials in a row failed: look at tune.space and at the column "
            "reason of trials.csv; tune.stop.failures=0 tries on"
        )
    return bool(stop.stall and tally.stalled >= stop.stall)


def count(study: Study) -> Tally:
    """Return how far a study is."""
    trials = study.get_trials(deepcopy=False)
    finished = [trial for trial in trials if trial.state in FINISHED]
    in_a_row = 0
    for trial in trials:
        if trial.state == TrialState.FAIL:
            in_a_row += not _abandoned(trial)
        elif trial.state in FINISHED:
            in_a_row = 0
    complete = [trial for trial in finished if trial.state == TrialState.COMPLETE]
    best = min(complete, key=lambda trial: (trial.value, trial.number), default=None)
    return Tally(
        finished=len(finished),
        running=sum(trial.state == TrialState.RUNNING for trial in trials),
        failed=sum(trial.state == TrialState.FAIL for trial in trials),
        failed_in_a_row=in_a_row,
        stalled=0 if best is None else sum(trial.number > best.number for trial in finished),
    )


def _one(
    store: Store,
    study: Study,
    objective: TrialObjective,
    config: Config,
    release: Callable[[], object],
) -> None:
    """Begin a trial within the claim, release it, and run the trial to its end."""
    number = _draw_number(study)
    study.sampler = make_sampler(config.tune, derive_seed(config.seed, "sampler", number))
    ended: list[int] = []

    def begin(trial: Trial) -> float:
        store.begin(trial)
        trial.set_user_attr(DRAW, number)
        release()
        try:
            value = objective(trial)
            if not math.isfinite(value):
                raise ArithmeticError(f"the objective is {value}")
        except FAULTS as error:
            ended.append(trial.number)
            LOGGER.warning("trial %d failed: %s", trial.number, _sentence(error))
            trial.set_user_attr(REASON, _sentence(error))
            raise
        ended.append(trial.number)
        return value

    try:
        study.optimize(begin, n_trials=1, catch=FAULTS)
    except Exception as error:
        if (refused := _of_the_disk(error)) is not None:
            raise refused from None
        # This worker was taken for dead, so another has repeated its trial: Optuna, which cannot
        # end a trial twice, raises whatever comes. So it does where the server has gone: queried
        # here, the storage says so itself.
        trials = study.get_trials(deepcopy=False)
        if not ended or trials[ended[0]].state != TrialState.FAIL:
            raise
        LOGGER.warning("trial %d came too late and does not count", ended[0])


def _draw_number(study: Study) -> int:
    """The least number that seeds no trial yet but such as were cut off."""
    trials = study.get_trials(deepcopy=False)
    begun = (t for t in trials if t.state != TrialState.WAITING and not _abandoned(t))
    taken = {trial.user_attrs.get(DRAW, trial.number) for trial in begun}
    return next(number for number in range(len(trials) + 1) if number not in taken)


def _of_the_disk(error: BaseException | None) -> OSError | None:
    """The error of a disk that Optuna raised another one over, None where there is none."""
    while error is not None:
        if isinstance(error, OSError) and error.filename is not None:
            return error
        error = error.__context__
    return None


def _bury(store: Store, study: Study) -> None:
    """Fail the trials whose worker is dead; within the claim."""
    for trial in store.abandoned(study):
        study._storage.set_trial_user_attr(trial._trial_id, REASON, ABANDONED)
        study.tell(trial.number, state=TrialState.FAIL)


def _queue_starts(study: Study, config: Config) -> None:
    """Queue the trials of ``tune.start`` that are not there yet, or were cut off."""
    for index, (point, problem) in enumerate(starting_points(config)):
        tried = [t for t in study.get_trials(deepcopy=False) if t.user_attrs.get(START) == index]
        if not problem and all(_abandoned(trial) for trial in tried):
            study.enqueue_trial(point, user_attrs={START: index})


def _abandoned(trial: FrozenTrial) -> bool:
    failed = trial.state == TrialState.FAIL
    return failed and trial.user_attrs.get(REASON, ABANDONED) == ABANDONED


def _sentence(error: BaseException) -> str:
    lines = str(error).strip().splitlines()
    return f"{type(error).__name__}: {lines[0]}" if lines else type(error).__name__
