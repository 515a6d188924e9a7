"""Cells of the ladder: a robot's trials with one perception, one agent and one solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

from pipeline.locations import results

# Choices of each part; the last one is its oracle.
PERCEPTIONS = ("miscalibrated", "camera", "perfect")
AGENTS = ("local", "endpoint", "policy")
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

    def overrides(self, trials: int, replay: bool = False) -> list[str]:
        """The keys of its run; `python -m pipeline grasp` takes them as well.

        Args:
            trials: How many.
            replay: Whether a language model's answers are those that it gave before.
        """
        return [
            f"robot={self.robot}",
            f"perception={self.perception}",
            *self._agent(replay),
            f"grasp.solver={self.solver}",
            f"grasp.trials={trials}",
            "grasp.placements=pinned",
            "grasp.protocol.evidence=failures",
            f"results_dir={FOLDER / self.robot / self.name}",
        ]

    def _agent(self, replay: bool) -> list[str]:
        """What a language model answers is kept, for each cell apart."""
        if self.agent == AGENTS[-1]:
            return [f"agent={self.agent}"]
        file = FOLDER / self.robot / self.name / "messages.jsonl"
        if replay:
            return ["agent=replay", f"agent.file={file}"]
        return [f"agent={self.agent}", f"agent.record={file}"]


def cells(robots: Sequence[str], agents: Sequence[str]) -> list[Cell]:
    """All cells, the most telling ones first: without any oracle, with all, then the others.

    Args:
        robots: In turns within each cell.
        agents: Of `AGENTS`.
    """
    ladder = [*product(PERCEPTIONS, [each for each in AGENTS if each in agents], SOLVERS)]
    ladder = [ladder[0], ladder[-1], *ladder[1:-1]]
    return [Cell(robot, *parts) for parts in ladder for robot in robots]
