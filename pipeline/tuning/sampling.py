"""Samplers and pruners: what is tried next, and which trials are cut short."""

from __future__ import annotations

import math

from optuna import Study
from optuna.pruners import BasePruner, HyperbandPruner, MedianPruner, NopPruner, PercentilePruner
from optuna.samplers import BaseSampler, RandomSampler, TPESampler
from optuna.trial import FrozenTrial, TrialState

from pipeline.tuning.config import PrunerConfig, TuneConfig

DRAW = "draw"  # attribute of a trial: the number that its draws and its training are seeded by
WHOLE = 100  # trials report in per cent of their schedule, whatever their batch size


def make_sampler(tune: TuneConfig, seed: int) -> BaseSampler:
    """Return the sampler that ``tune.sampler`` names.

    `tpe` models all parameters that are drawn together, in one group for each set of them: widths
    that only deeper networks have get a model of their own. `tpe_independent` models each alone and
    knows nothing of trials that still run, as Optuna did when the paper's search ran.
    """
    if tune.sampler == "random":
        return RandomSampler(seed=seed)
    if tune.sampler == "tpe_independent":
        return TPESampler(
            seed=seed, n_startup_trials=tune.startup, multivariate=False, constant_liar=False
        )
    return TPESampler(
        seed=seed,
        n_startup_trials=tune.startup,
        multivariate=True,
        group=True,
        constant_liar=True,
    )


class Outclassed(BasePruner):
    """Cuts a trial that is far worse than every good trial was at the same share of its schedule.

    A learning rate that falls to zero sends a trial's loss down in the last stretch of its
    schedule, the more the higher the rate was: what looks bad half-way may well end best, and
    pruners that rank trials half-way cut it. Whether a trial can still end well
    follows from the trials that did: only what none of them ever was is cut.

    Args:
        keep: Share of the complete trials that count as good.
        margin: Times worse than the worst of these that a trial must be.
        startup: Complete trials before anything is cut.
        after: Share of a trial's schedule before which nothing is cut.
    """

    def __init__(self, keep: float, margin: float, startup: int, after: float) -> None:
        self.keep, self.margin = keep, margin
        self.startup, self.after = startup, after

    def prune(self, study: Study, trial: FrozenTrial) -> bool:
        """Whether a trial should be cut at its latest report."""
        share = trial.last_step
        complete = study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        if share is None or share < WHOLE * self.after or len(complete) < max(1, self.startup):
            return False
        complete.sort(key=lambda one: one.value)
        good = complete[: math.ceil(self.keep * len(complete))]
        were = [_value_at(one, share) for one in good]
        worst = max((value for value in were if value is not None), default=math.inf)
        return bool(trial.intermediate_values[share] > self.margin * worst)


def _value_at(trial: FrozenTrial, share: int) -> float | None:
    """The latest report of a trial up to a share of its schedule."""
    steps = [step for step in trial.intermediate_values if step <= share]
    return trial.intermediate_values[max(steps)] if steps else None


def make_pruner(pruner: PrunerConfig) -> BasePruner:
    """Return the pruner that ``tune.pruner`` names; all compare at equal shares of schedules."""
    warm_up = round(WHOLE * pruner.after)
    if pruner.kind == "none":
        return NopPruner()
    if pruner.kind == "hyperband":
        return HyperbandPruner(min_resource=max(1, warm_up), max_resource=WHOLE)
    if pruner.kind == "median":
        return MedianPruner(n_startup_trials=pruner.startup, n_warmup_steps=warm_up)
    if pruner.kind == "percentile":
        return PercentilePruner(
            WHOLE * pruner.keep, n_startup_trials=pruner.startup, n_warmup_steps=warm_up
        )
    return Outclassed(pruner.keep, pruner.margin, pruner.startup, pruner.after)
