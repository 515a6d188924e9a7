"""Cells of the ladder: a robot's trials with one perception, one agent and one solver."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import pandas as pd

from pipeline.config import compose
from pipeline.data.rows import RowCheckpoint
from pipeline.embodiment.series import AgentSeries
from pipeline.grasping.series import KEY
from pipeline.locations import results
from pipeline.stages import grasp
from pipeline.stages.grasp_units import load_runner, row_identity, run_units
from pipeline.stages.running import with_weights

PERCEPTIONS = ("miscalibrated", "camera", "perfect")  # from the world's to the oracle
AGENTS = ("endpoint", "replay", "policy")  # likewise
SOLVERS = ("cycleik", "cycleik_refined")  # likewise
FOLDER = results() / "ladder"


@dataclass(frozen=True)
class Cell:
    """One cell; the values are choices of `perception`, `agent` and `grasp.solver`."""

    robot: str
    perception: str
    agent: str
    solver: str

    @property
    def name(self) -> str:
        """As `--cells` takes it."""
        return f"{self.perception}/{self.agent}/{self.solver}"

    def overrides(self, trials: int) -> list[str]:
        """The keys of its run; `python -m pipeline grasp` takes them as well."""
        return [
            f"robot={self.robot}",
            f"perception={self.perception}",
            f"agent={self.agent}",
            f"grasp.solver={self.solver}",
            f"grasp.trials={trials}",
            "grasp.placements=pinned",
            f"results_dir={FOLDER / self.robot / self.name}",
            *self._messages(),
        ]

    def _messages(self) -> list[str]:
        """What an endpoint answers is kept, and a replay answers from it."""
        file = FOLDER / self.robot / self.perception / f"messages-{self.solver}.jsonl"
        keys = {"endpoint": "record", "replay": "file"}
        return [f"agent.{keys[self.agent]}={file}"] if self.agent in keys else []


def cells(robots: Sequence[str], agents: Sequence[str]) -> list[Cell]:
    """All cells, the most telling ones first: without any oracle, with all, then the others.

    Args:
        robots: In turns within each cell.
        agents: Of `AGENTS`.
    """
    ladder = [*product(PERCEPTIONS, [each for each in AGENTS if each in agents], SOLVERS)]
    ladder = [ladder[0], ladder[-1], *ladder[1:-1]]
    return [Cell(robot, *parts) for parts in ladder for robot in robots]


class CellRows:
    """Rows of a cell, kept as they are made.

    Attributes:
        cell: The cell.
        network: Name of the networks that solve, for people.
    """

    def __init__(self, cell: Cell, trials: int, overrides: Sequence[str] = ()) -> None:
        """Load what the cell needs.

        Args:
            cell: The cell.
            trials: How many.
            overrides: Further keys, such as of the engine and of an endpoint.

        Raises:
            PipelineError: The robot has no scene, no camera or no pinned placements.
        """
        config = compose([*cell.overrides(trials), *overrides])
        grasp.check(config)
        self.cell = cell
        self._config = with_weights(config, [cell.solver])
        runner = load_runner(self._config)
        assert isinstance(runner, AgentSeries)
        self._runner = runner
        identity = row_identity(self._config, runner)
        self.network = identity.network
        self._kept = RowCheckpoint(identity.path, KEY)

    def run(self, progress: Callable[[dict[str, Any]], object]) -> None:
        """Run the trials that are not kept yet."""
        run_units(self._config, self._runner, self._kept)
        self._runner.run(self._kept, progress)

    def rows(self) -> pd.DataFrame:
        """Return the raw rows that are kept, by their numbers; fewer than wanted if it was cut."""
        numbers = range(self._config.grasp.trials)
        kept = [row for number in numbers if (row := self._kept.get(number)) is not None]
        cell = self.cell
        return pd.DataFrame(kept).assign(
            perception=cell.perception, agent=cell.agent, solver=cell.solver
        )
