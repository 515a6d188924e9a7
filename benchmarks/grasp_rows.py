"""Raw rows of grasp trials for a study, kept as they are made so that a killed one goes on."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from typing import Any

import pandas as pd

from baselines import SolverError
from pipeline.config import compose
from pipeline.data.rows import RowCheckpoint
from pipeline.errors import PipelineError
from pipeline.grasping import ablation, series
from pipeline.grasping.ablation import Study
from pipeline.progress import bar
from pipeline.stages import grasp
from pipeline.stages.graph import STAGES
from pipeline.stages.grasp_units import load_runner, row_identity, run_units
from pipeline.stages.running import with_weights


class GraspRows:
    """The trials of one run, or of a study of `grasp.ablation`.

    The rows lie in `checkpoint` below the run's `results_dir`; more trials of the same run are
    added to them.

    Attributes:
        network: Name of the networks that solve, for people; nothing if none does.
        wanted: Number of rows.
    """

    def __init__(self, overrides: Sequence[str]) -> None:
        """Load robot, solver, perception and agent.

        Args:
            overrides: Of the run.

        Raises:
            PipelineError: The run cannot be made, and why.
        """
        config = compose(overrides)
        grasp.check(config)
        self._config = with_weights(config, STAGES["grasp"].solver_names(config))
        self._runner = load_runner(self._config)
        identity = row_identity(self._config, self._runner)
        self.network = identity.network
        self._keys = [key for keys in self._runner.units().values() for key in keys]
        self.wanted = len(self._keys)
        key = ablation.KEY if isinstance(self._runner, Study) else series.KEY
        self._kept = RowCheckpoint(identity.path, key)

    def run(self, progress: Callable[[dict[str, Any]], object]) -> None:
        """Run what is not kept yet.

        Args:
            progress: Called with each row, also with those that were kept.
        """
        run_units(self._config, self._runner, self._kept)
        self._runner.run(self._kept, progress)

    def rows(self) -> pd.DataFrame:
        """Return the rows that are kept, in their order; fewer than wanted if a run was cut."""
        kept = [self._kept.get(*key) for key in self._keys]
        return pd.DataFrame([row for row in kept if row is not None])


def grasp_arguments(
    document: str | None, robots: Sequence[str] | None = None
) -> argparse.ArgumentParser:
    """Return a parser of what every study of grasps takes; it has options of its own beside these.

    Args:
        document: Of the module; its first line describes the study.
        robots: That it can be made of; None for any.
    """
    parser = argparse.ArgumentParser(description=(document or "").splitlines()[0])
    parser.add_argument("--robots", nargs="+", choices=robots, default=["nico", "nicol"])
    parser.add_argument("--as-is", action="store_true", help="run nothing: what is kept")
    parser.add_argument("--write", action="store_true", help="into results/studies")
    parser.add_argument("overrides", nargs="*", help="such as grasp.solver=cycleik_refined")
    return parser


def trials(overrides: Sequence[str], title: str, as_is: bool) -> GraspRows:
    """Run what is missing of a study's trials under a bar; with ``as_is`` only find what is kept.

    Raises:
        SystemExit: The run cannot be made, and why.
    """
    try:
        made = GraspRows(overrides)
    except (PipelineError, SolverError) as error:
        raise SystemExit(str(error)) from error
    if not as_is:
        with bar(made.wanted, "trial", title) as shown:
            made.run(lambda row: shown.update())
    return made
