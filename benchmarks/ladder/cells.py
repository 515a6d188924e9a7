"""Cells of the ladder: a robot's trials with one perception, one agent and one solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import pandas as pd

from pipeline.locations import results

# Choices of each part; the last one is its oracle.
PERCEPTIONS = ("miscalibrated", "camera", "perfect")
AGENTS = ("endpoint", "replay", "policy")
SOLVERS = ("cycleik", "cycleik_refined")
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


def of_cell(cell: Cell, rows: pd.DataFrame) -> pd.DataFrame:
    """Return raw rows under the names of their cell: a replay's say whom it replays."""
    return rows.assign(perception=cell.perception, agent=cell.agent, solver=cell.solver)
