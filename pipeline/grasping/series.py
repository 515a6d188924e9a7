"""A series of trials: resumable row by row, filmed where the configuration asks for it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

from pipeline.grasping.config import GraspConfig
from pipeline.grasping.trial import CLASSES, run_trial
from pipeline.grasping.video import Recorder

if TYPE_CHECKING:
    from baselines import Solver
    from robots import Robot

STILLS = (4, 2)  # columns and rows of a contact sheet


@dataclass(frozen=True)
class Series:
    """What all trials of a series share.

    Attributes:
        config: The experiment.
        robot: The robot.
        solver: Inverse kinematics of its motions.
        repair: Solver that mends waypoints, or None.
        seed: Root seed.
    """

    config: GraspConfig
    robot: Robot
    solver: Solver
    repair: Solver | None
    seed: int

    def run(self, kept: Path, progress: Callable[[dict[str, Any]], object]) -> pd.DataFrame:
        """Run the trials that are not yet kept and return one raw row for each.

        Args:
            kept: JSON lines, one finished trial each; a killed series goes on after the last whole
                line.
            progress: Called with each row, also with those that were kept.
        """
        kept.parent.mkdir(parents=True, exist_ok=True)
        rows = {row["trial"]: row for row in _read_lines(kept)}
        for number in range(self.config.trials):
            if number not in rows:
                rows[number] = self.trial(number)
                with kept.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(rows[number]) + "\n")
            progress(rows[number])
        return pd.DataFrame([rows[number] for number in range(self.config.trials)])

    def trial(self, number: int, recorder: Recorder | None = None) -> dict[str, Any]:
        """Run one trial; its number and the seed fix everything."""
        return run_trial(
            self.config, self.robot, self.solver, number, self.seed, self.repair, recorder
        )

    def film(self, rows: pd.DataFrame, folder: Path) -> list[Path]:
        """Run the trials that are to be filmed once more, now with the camera on.

        A trial is a function of its number, so the film shows what the row says.

        Returns:
            The videos; beside each lies a contact sheet of stills as PNG.
        """
        films = []
        for number in self._filmed(rows):
            recorder = Recorder(self.config.recording)
            outcome = str(self.trial(number, recorder)["class"]).lower().replace(" ", "_")
            path = folder / f"trial{number:03d}_{outcome}.mp4"
            recorder.write(path)
            recorder.stills(*STILLS).save(path.with_suffix(".png"))
            films.append(path)
        return films

    def _filmed(self, rows: pd.DataFrame) -> list[int]:
        if self.config.video == "all":
            return [int(number) for number in rows["trial"]]
        if self.config.video == "classes":
            firsts = [rows.loc[rows["class"] == name, "trial"].head(1) for name in CLASSES]
            return sorted(int(number) for first in firsts for number in first)
        return [0] if self.config.video == "first" else []


def _read_lines(path: Path) -> list[dict[str, Any]]:
    """Read whole JSON lines; a line that a kill cut off is cut off the file as well."""
    if not path.exists():
        return []
    rows: list[dict[str, Any]] = []
    whole = []
    for line in path.read_text(encoding="utf-8").splitlines():
        try:
            rows.append(json.loads(line))
        except ValueError:
            break
        whole.append(line)
    path.write_text("".join(f"{line}\n" for line in whole), encoding="utf-8")
    return rows
