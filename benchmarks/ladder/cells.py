"""Cells of the ladder: a robot's trials with one perception, one agent and one solver."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from pipeline.data.files import write_text
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

    @property
    def messages(self) -> Path:
        """Where what a language model answers is kept."""
        return FOLDER / self.robot / self.name / "messages.jsonl"

    def overrides(self, trials: int, replay: Path | None = None) -> list[str]:
        """The keys of its run; `python -m pipeline grasp` takes them as well.

        Args:
            trials: How many.
            replay: File with a language model's answers in place of the model.
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

    def _agent(self, replay: Path | None) -> list[str]:
        if self.agent == AGENTS[-1]:
            return [f"agent={self.agent}"]
        if replay is not None:
            return ["agent=replay", f"agent.file={replay}"]
        return [f"agent={self.agent}", f"agent.record={self.messages}"]


def keep_messages(cells: Sequence[Cell], path: Path) -> None:
    """Write all exchanges with language models in some cells into one file, each of them once."""
    files = [cell.messages for cell in cells if cell.messages.is_file()]
    lines = dict.fromkeys(line for file in files for line in file.read_text("utf-8").splitlines())
    if lines:
        write_text(path, "".join(f"{line}\n" for line in lines))


def cells(robots: Sequence[str], agents: Sequence[str]) -> list[Cell]:
    """All cells, the most telling ones first: without any oracle, with all, then the others.

    Args:
        robots: In turns within each cell.
        agents: Of `AGENTS`.
    """
    ladder = [*product(PERCEPTIONS, [each for each in AGENTS if each in agents], SOLVERS)]
    ladder = [ladder[0], ladder[-1], *ladder[1:-1]]
    return [Cell(robot, *parts) for parts in ladder for robot in robots]
