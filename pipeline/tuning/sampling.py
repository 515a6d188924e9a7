"""Samplers and pruners: what is tried next, and which trials are cut short."""

from __future__ import annotations

from optuna.pruners import BasePruner, HyperbandPruner, MedianPruner, NopPruner, PercentilePruner
from optuna.samplers import BaseSampler, RandomSampler, TPESampler

from pipeline.tuning.config import PrunerConfig, TuneConfig

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


def make_pruner(pruner: PrunerConfig) -> BasePruner:
    """Return the pruner that ``tune.pruner`` names.

    A learning rate that falls to zero sends a trial's loss down in the last stretch of its
    schedule, the more the higher the rate was: what looks bad early may well be best. So trials are
    compared at equal shares of their schedules only, and the percentile pruner cuts those that are
    among the worst even after ``after`` of it.
    """
    warm_up = round(WHOLE * pruner.after)
    if pruner.kind == "none":
        return NopPruner()
    if pruner.kind == "hyperband":
        return HyperbandPruner(min_resource=max(1, warm_up), max_resource=WHOLE)
    if pruner.kind == "median":
        return MedianPruner(n_startup_trials=pruner.startup, n_warmup_steps=warm_up)
    return PercentilePruner(
        WHOLE * pruner.keep, n_startup_trials=pruner.startup, n_warmup_steps=warm_up
    )
