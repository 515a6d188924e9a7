"""Any solver judged as the stage `evaluate` judges its own: raw rows in a notebook."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from baselines.checks import check_poses

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

    from baselines import Budget, Solver


def evaluate(
    solver: Solver,
    poses: ArrayLike,
    batch_size: int = 1,
    budget: Budget | None = None,
    name: str = "",
) -> pd.DataFrame:
    """Solve poses and judge the answers: errors come from the joints, never from the solver.

    The process stays on one core while it runs, and what conf/evaluate says besides holds here too.

    Args:
        solver: Of `load_solver`, or a `baselines.Solver` of one's own.
        poses: (N, 7) targets in the base frame, x y z in m, then unit qw qx qy qz; N > 0.
        batch_size: Poses handed over in one call.
        budget: Cost allowed per pose; the solver's own where left out.
        name: Of the solver in the rows; its own, or that of its class, where left out.

    Returns:
        One row a pose; `pipeline.evaluation.rows.COLUMNS` says what each column means.

    Raises:
        EvaluationError: No poses, or a solver that answers with the wrong shape.
        PoseError: Poses of wrong shape, not finite or with a quaternion that is not unit.
        ConfigError: `batch_size` is not positive.
        BudgetError: A budget of a kind that the solver does not heed.
    """
    from pipeline.config import compose  # Hydra, pandas and torch
    from pipeline.errors import ConfigError
    from pipeline.evaluation.runner import evaluate_solver
    from pipeline.evaluation.task import EvaluationTask

    targets = check_poses(poses)
    if budget is not None:
        solver.solve(targets[:0], budget=budget)  # refuses what it does not heed
    limits = (None, None) if budget is None else (budget.time_s, budget.iterations)
    try:
        config = replace(
            compose().evaluate,
            time_s=limits[0],
            time_factor={},
            iterations=limits[1],
            batch_sizes=[batch_size],
            error_batch_size={},
            trajectories=0,
        )
    except ValueError as error:
        raise ConfigError(str(error)) from error
    label = name or solver.name or type(solver).__name__
    return evaluate_solver(EvaluationTask(solver.robot, solver, targets, 0, label), config)
