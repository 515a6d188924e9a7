"""Trials with errors: each with sizes of its own, or all with the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import qmc

from baselines import SolverError
from benchmarks.hardware.errors import ERRORS, values
from pipeline.config import compose
from pipeline.data.rows import Resumable, RowCheckpoint
from pipeline.errors import PipelineError
from pipeline.grasping.ablation import changed
from pipeline.grasping.placements import TRIALS
from pipeline.grasping.series import Series
from pipeline.locations import results
from pipeline.progress import bar
from pipeline.provenance import digest
from pipeline.stages import grasp
from pipeline.stages.graph import STAGES
from pipeline.stages.grasp_units import load_runner, row_identity
from pipeline.stages.running import with_weights

Array = NDArray[np.float64]
NEAR = 2.0  # power of the shares' density: most trials have small errors, which are what is sought
SEED = 5  # of the sizes


def design(count: int) -> Array:
    """Shares of the errors' ranges for so many trials, (count, 6).

    Points of Sobol's sequence, scrambled, more of them near zero; the first ones of a longer
    design are the shorter one.

    Args:
        count: Trials.
    """
    power = int(np.ceil(np.log2(max(count, 2))))
    points = qmc.Sobol(len(ERRORS), rng=SEED).random_base2(power)[:count]
    shares: Array = points**NEAR
    return shares


class Spoilt(Resumable):
    """Trials of a robot on its pinned placements, each with errors of its own sizes.

    Beyond the placements these begin anew with other draws; where there are no errors nothing is
    drawn, and they would be the same trials.

    Args:
        series: The trials without errors.
        shares: (N, 6) of the errors' ranges, a line a trial.
    """

    def __init__(self, series: Series, shares: Array) -> None:
        self.series, self.shares = series, shares

    def units(self) -> dict[int, list[tuple[object, ...]]]:
        """See `Resumable`."""
        return {number: [(number,)] for number in range(len(self.shares))}

    def unit(self, unit: int) -> list[dict[str, Any]]:
        """See `Resumable`."""
        again, number = divmod(unit, TRIALS)
        config = changed(self.series.config, values(self.shares[unit]))
        series = replace(self.series, config=config, seed=self.series.seed + again)
        shares = zip(ERRORS, self.shares[unit], strict=True)
        sizes = {f"share_{error.key}": float(share) for error, share in shares}
        return [{**series.trial(number), "number": unit, **sizes}]


def run(
    robot: str, shares: Array, name: str, overrides: Sequence[str], as_is: bool
) -> tuple[pd.DataFrame, str]:
    """Run what is missing of trials with errors; return the rows and the network that solves.

    The rows are kept as they are made, below results/hardware.

    Args:
        robot: Name of the robot.
        shares: (N, 6) of the errors' ranges.
        name: Of these shares; more of the same are added to what is kept.
        overrides: Of the run.
        as_is: Whether to run nothing.

    Raises:
        SystemExit: The run cannot be made, and why.
    """
    try:
        return _run(robot, shares, name, overrides, as_is)
    except (PipelineError, SolverError) as error:
        raise SystemExit(str(error)) from error


def _run(
    robot: str, shares: Array, name: str, overrides: Sequence[str], as_is: bool
) -> tuple[pd.DataFrame, str]:
    plain = ["perception=perfect", "agent=none", "grasp.placements=pinned", "grasp.video=none"]
    config = compose([f"robot={robot}", *plain, f"grasp.trials={TRIALS}", *overrides])
    grasp.check(config)
    config = with_weights(config, STAGES["grasp"].solver_names(config))
    series = load_runner(config)
    if not isinstance(series, Series):
        raise PipelineError("the trials are single objects at known places: leave out perception")
    identity = row_identity(config, series)
    ranges = digest([[[error.key, error.perfect, error.worst] for error in ERRORS], NEAR, SEED])
    path = results() / "hardware" / f"{identity.path.stem}-{ranges[:8]}-{name}.jsonl"
    kept, spoilt = RowCheckpoint(path, ("number",)), Spoilt(series, shares)
    if as_is:
        rows = pd.DataFrame([row for n in range(len(shares)) if (row := kept.get(n)) is not None])
    else:
        with bar(len(shares), "trial", f"{robot}, {name}") as shown:
            rows = spoilt.run(kept, lambda row: shown.update())
    return rows, identity.network
